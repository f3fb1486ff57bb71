"""Flips bits in the tables of a running program. Its symbol `polhode_tables` says where they lie."""

import ctypes
import os
import pathlib
import random
import struct
import subprocess

from polhode_ground.common.errors import BadInput

SYMBOL = "polhode_tables"
ET_EXEC = 2  # a program that lies where its file says, as opposed to one that is moved when it is loaded


class Span(ctypes.Structure):
    _fields_ = [("begin", ctypes.c_void_p), ("octets", ctypes.c_size_t)]


def symbol_address(program: pathlib.Path) -> int:
    """As the file has it. @raise BadInput for a program without symbols."""
    names = subprocess.run(["nm", program], capture_output=True, text=True).stdout
    for line in names.splitlines():
        if line.endswith(f" {SYMBOL}"):
            return int(line.split()[0], 16)
    raise BadInput(f"{program}: has no symbol {SYMBOL}; a program of the build folder is needed, not stripped")


def _load_address(pid: int, program: pathlib.Path) -> int:
    """Where the program was loaded, relative to its file's addresses."""
    with open(program, "rb") as file:
        if struct.unpack_from("<H", file.read(18), 16)[0] == ET_EXEC:
            return 0
    name = str(program.resolve())
    with open(f"/proc/{pid}/maps") as maps:
        return next(int(line.split("-")[0], 16) for line in maps if line.rstrip().endswith(name))


class Memory:
    """Of another process of this user."""

    def __init__(self, pid: int):
        self._pid = pid
        self._calls = ctypes.CDLL(None, use_errno=True)

    def _transfer(self, call, address: int, buffer) -> None:
        octets = ctypes.sizeof(buffer)
        here = Span(ctypes.addressof(buffer), octets)
        there = Span(address, octets)
        done = getattr(self._calls, call)(
            self._pid, ctypes.byref(here), ctypes.c_ulong(1), ctypes.byref(there), ctypes.c_ulong(1), ctypes.c_ulong(0)
        )
        if done != octets:
            number = ctypes.get_errno()
            raise OSError(number, f"{call} at {address:#x}: {os.strerror(number)}")

    def read(self, address: int, octets: int) -> bytes:
        buffer = (ctypes.c_ubyte * octets)()
        self._transfer("process_vm_readv", address, buffer)
        return bytes(buffer)

    def write(self, address: int, octets: bytes) -> None:
        self._transfer("process_vm_writev", address, (ctypes.c_ubyte * len(octets))(*octets))


def flip(pid: int, program: pathlib.Path, flips: int, chance: random.Random) -> int:
    """That many bits of the tables, drawn anew each. The process is to be stopped. @return octets of the tables."""
    memory = Memory(pid)
    where = _load_address(pid, program) + symbol_address(program)
    begin, octets = struct.unpack("<QQ", memory.read(where, 16))
    for _ in range(flips):
        bit = chance.randrange(8 * octets)
        address = begin + bit // 8
        memory.write(address, bytes([memory.read(address, 1)[0] ^ 1 << bit % 8]))
    return octets
