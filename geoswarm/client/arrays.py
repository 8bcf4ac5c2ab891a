"""Arrays in records of answers; NumPy is loaded with the first of them, so that importing the client stays cheap."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from pydantic import BeforeValidator

__all__ = ["Floats", "Integers"]

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats: TypeAlias = NDArray[np.float64]
    """Numbers, read-only; NaN where the service has null."""

    Integers: TypeAlias = NDArray[np.int64]
    """Whole numbers, read-only."""

else:

    def _array(values: Any, kind: str) -> Any:
        import numpy as np

        if values is None:
            raise ValueError("must be a list of numbers, not null")
        try:
            array = np.array(values, dtype=kind)
        except TypeError as error:  # pydantic reports ValueError only
            raise ValueError(str(error)) from None
        array.flags.writeable = False
        return array

    Floats = Annotated[Any, BeforeValidator(lambda values: _array(values, "float64"))]
    Integers = Annotated[Any, BeforeValidator(lambda values: _array(values, "int64"))]
