"""Job objects of Windows: the processes of one end when its last handle is closed, also by the death of this program.

Written after Microsoft's documentation of ``CreateJobObject``, ``SetInformationJobObject`` and
``AssignProcessToJobObject``; it could not be tried where this program is made (docs/agents.md).
"""

from __future__ import annotations

import ctypes
import logging
import sys
from typing import Any

__all__ = ["JobObject", "has_job_objects"]

log = logging.getLogger(__name__)

EXTENDED_LIMITS = 9  # JobObjectExtendedLimitInformation
KILL_ON_CLOSE = 0x2000  # JOB_OBJECT_LIMIT_KILL_ON_JOB_CLOSE
ACCESS = 0x0001 | 0x0100  # PROCESS_TERMINATE, PROCESS_SET_QUOTA


class _BasicLimits(ctypes.Structure):
    _fields_ = (
        ("per_process_user_time_limit", ctypes.c_int64),
        ("per_job_user_time_limit", ctypes.c_int64),
        ("limit_flags", ctypes.c_uint32),
        ("minimum_working_set_size", ctypes.c_size_t),
        ("maximum_working_set_size", ctypes.c_size_t),
        ("active_process_limit", ctypes.c_uint32),
        ("affinity", ctypes.c_size_t),
        ("priority_class", ctypes.c_uint32),
        ("scheduling_class", ctypes.c_uint32),
    )


class _ExtendedLimits(ctypes.Structure):
    _fields_ = (
        ("basic", _BasicLimits),
        ("io_counters", ctypes.c_uint64 * 6),
        ("process_memory_limit", ctypes.c_size_t),
        ("job_memory_limit", ctypes.c_size_t),
        ("peak_process_memory_used", ctypes.c_size_t),
        ("peak_job_memory_used", ctypes.c_size_t),
    )


def has_job_objects() -> bool:
    """Whether this system has job objects."""
    return sys.platform == "win32" and hasattr(ctypes, "windll")


def _kernel() -> Any:
    kernel = ctypes.WinDLL("kernel32", use_last_error=True)  # type: ignore[attr-defined, unused-ignore]  # Windows only
    handle = ctypes.c_void_p
    kernel.CreateJobObjectW.restype = handle
    kernel.CreateJobObjectW.argtypes = (ctypes.c_void_p, ctypes.c_wchar_p)
    kernel.OpenProcess.restype = handle
    kernel.OpenProcess.argtypes = (ctypes.c_uint32, ctypes.c_int, ctypes.c_uint32)
    kernel.SetInformationJobObject.argtypes = (handle, ctypes.c_int, ctypes.c_void_p, ctypes.c_uint32)
    kernel.AssignProcessToJobObject.argtypes = (handle, handle)
    kernel.CloseHandle.argtypes = (handle,)
    return kernel


class JobObject:
    """One job object. Where the system refuses it, the tree of processes is found by their parents."""

    def __init__(self) -> None:
        self._kernel = _kernel()
        self._handle = self._kernel.CreateJobObjectW(None, None)
        limits = _ExtendedLimits()
        limits.basic.limit_flags = KILL_ON_CLOSE
        size = ctypes.sizeof(limits)
        if not self._handle or not self._kernel.SetInformationJobObject(
            self._handle, EXTENDED_LIMITS, ctypes.byref(limits), size
        ):
            log.warning("no job object is available: runs of a killed agent may continue")

    def add(self, pid: int) -> None:
        """Put a process into it, and with it all that it will start."""
        process = self._kernel.OpenProcess(ACCESS, False, pid)
        if not process:
            return
        if not self._kernel.AssignProcessToJobObject(self._handle, process):
            log.warning("process %d could not be put into a job object", pid)
        self._kernel.CloseHandle(process)

    def close(self) -> None:
        """End everything in it."""
        if self._handle:
            self._kernel.CloseHandle(self._handle)
            self._handle = None
