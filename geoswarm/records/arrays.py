"""Arrays in records; NumPy is loaded with the first of them, so that importing a record stays cheap."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

__all__ = ["Floats", "Integers", "Measured"]

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from pydantic_core.core_schema import CoreSchema

    Measured: TypeAlias = NDArray[np.float64]
    """Numbers, read-only, all finite."""

    Floats: TypeAlias = NDArray[np.float64]
    """Numbers, read-only; NaN is null in JSON."""

    Integers: TypeAlias = NDArray[np.int64]
    """Whole numbers, read-only."""

else:

    class _Array:
        """How an array is read and written; the schema is that of a list."""

        def __init__(self, kind: str, *, gaps: bool) -> None:
            self.kind = kind
            self.gaps = gaps

        def __get_pydantic_core_schema__(self, _source: Any, _handler: Any) -> CoreSchema:
            from pydantic_core import core_schema

            number = core_schema.float_schema() if self.kind == "float64" else core_schema.int_schema()
            listed = core_schema.list_schema(core_schema.nullable_schema(number) if self.gaps else number)
            written = core_schema.plain_serializer_function_ser_schema(self._list, return_schema=listed)
            return core_schema.no_info_plain_validator_function(self._array, serialization=written)

        def _array(self, values: Any) -> Any:
            import numpy as np

            if values is None:
                raise ValueError("must be a list of numbers, not null")
            try:
                array = np.array(values, dtype=self.kind)
            except TypeError as error:  # pydantic reports ValueError only
                raise ValueError(str(error)) from None
            array.flags.writeable = False
            return array

        def _list(self, array: Any) -> list[Any]:
            import numpy as np

            if not self.gaps or np.isfinite(array).all():
                return array.tolist()
            return np.where(np.isfinite(array), array.astype(object), None).tolist()

    Measured = Annotated[Any, _Array("float64", gaps=False)]
    Floats = Annotated[Any, _Array("float64", gaps=True)]
    Integers = Annotated[Any, _Array("int64", gaps=False)]
