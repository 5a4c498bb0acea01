"""Program that holds a Bladed-style controller, so that only it ends where the library ends it.

It imports nothing but the standard library, and ends with the process that started it. Requests
come and replies go as packets of a socket, each with a token that the request brings: whatever else
the library writes, on any descriptor, is no reply. Its output goes to stdout.

    python discon_child.py LIBRARY INPUT NAME DESCRIPTOR PARENT

A request is the token, then pairs (number of the record, value); a reply is the token, the flag of
the library, the values of `REPLIES`, and a message.
"""

import ctypes
import os
import signal
import socket
import struct
import sys

REPLIES = (35, 36, 42, 43, 44, 47, 48)
"""Records that the library sets: generator contactor, shaft brake, pitch of three blades, torque,
yaw rate."""

SIZE = 3300
"""Records of the swap array."""

TEXT = 1024
"""Length of messages."""

NO_LIBRARY = 3
"""Exit code where the library cannot be loaded, with the reason on stderr."""

TOKEN = 16
"""Bytes of a token."""

PACKET = 1 << 16
"""More bytes than any request or reply has."""

PAIR, REPLY = struct.Struct("<if"), struct.Struct(f"<i{len(REPLIES)}f")

_PR_SET_PDEATHSIG = 1


def main(library: str, infile: str, name: str, descriptor: str, parent: str) -> int:
    """Answer requests until there are no more."""
    end_with_parent(int(parent))
    try:
        discon = ctypes.CDLL(library).DISCON
    except (OSError, AttributeError) as error:
        print(error, file=sys.stderr)
        return NO_LIBRARY
    discon.restype = None
    swap = (ctypes.c_float * SIZE)()
    failed = ctypes.c_int(0)
    path, root = infile.encode(), name.encode()
    message = ctypes.create_string_buffer(TEXT)
    # lengths of the texts with their end, Bladed's records 49 to 51 and 64
    lengths = {49: TEXT, 50: len(path) + 1, 51: len(root) + 1, 64: TEXT}
    line = socket.socket(fileno=int(descriptor))
    while request := line.recv(PACKET):
        for record, value in PAIR.iter_unpack(request[TOKEN:]):
            swap[record - 1] = value
        for record, length in lengths.items():
            swap[record - 1] = length
        failed.value = 0
        discon(swap, ctypes.byref(failed), path, root, message)
        values = [swap[record - 1] for record in REPLIES]
        line.send(request[:TOKEN] + REPLY.pack(failed.value, *values) + message.value.strip())
    return 0


def end_with_parent(parent: int) -> None:
    """Let the kernel kill this process when its parent has ended, also within the library."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it ended before
        sys.exit(0)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
