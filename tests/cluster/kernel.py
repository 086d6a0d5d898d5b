"""Calls of Linux that Python 3.11 does not have: namespaces, mounts, and watching a file."""
import ctypes
import os
import select
import struct

CLONE_NEWNS, CLONE_NEWUTS, CLONE_NEWIPC = 0x00020000, 0x04000000, 0x08000000
CLONE_NEWPID, CLONE_NEWNET = 0x20000000, 0x40000000
OF_A_COMPUTER = CLONE_NEWNS | CLONE_NEWUTS | CLONE_NEWIPC | CLONE_NEWPID | CLONE_NEWNET

MS_RDONLY, MS_NOSUID, MS_NODEV, MS_BIND = 1, 2, 4, 4096
MS_REC, MS_PRIVATE = 16384, 1 << 18
_MOUNT_SETATTR, _AT_FDCWD, _AT_RECURSIVE, _ATTR_RDONLY = 442, -100, 0x8000, 1
_IN_MODIFY, _IN_NONBLOCK = 2, 0o4000

_libc = ctypes.CDLL(None, use_errno=True)


def _check(result, what):
    if result < 0:
        number = ctypes.get_errno()
        raise OSError(number, f"{what}: {os.strerror(number)}")
    return result


def unshare(flags):
    _check(_libc.unshare(flags), "unshare")


def mount(source, target, kind="", flags=0, options=""):
    encoded = [text.encode() if text else None for text in (str(source), str(target), kind)]
    _check(_libc.mount(*encoded, ctypes.c_ulong(flags), options.encode()),
           f"mount {kind or source} at {target}")


def bind(source, target):
    mount(source, target, flags=MS_BIND | MS_REC)


def set_read_only(path, is_read_only):
    """Every mount below `path`, as this mount namespace sees it."""
    bits = (_ATTR_RDONLY, 0) if is_read_only else (0, _ATTR_RDONLY)
    attributes = struct.pack("QQQQ", *bits, 0, 0)  # To set, to clear, propagation, user namespace.
    _check(_libc.syscall(_MOUNT_SETATTR, _AT_FDCWD, os.fsencode(path), _AT_RECURSIVE, attributes,
                         ctypes.c_size_t(len(attributes))), f"mount_setattr {path}")


class Watch:
    """Waits until a file grows."""

    def __init__(self, path):
        self.fd = _check(_libc.inotify_init1(_IN_NONBLOCK | os.O_CLOEXEC), "inotify")
        _check(_libc.inotify_add_watch(self.fd, os.fsencode(path), _IN_MODIFY), f"watch {path}")

    def wait(self, limit_s, *others):
        """Returns after a change since the last call, when another can be read, or in time."""
        if self.fd in select.select([self.fd, *others], [], [], max(0, limit_s))[0]:
            os.read(self.fd, 1 << 16)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.close(self.fd)
