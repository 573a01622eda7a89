"""C++ peers, compiled for this machine."""

import ctypes
import pathlib
import shutil
import subprocess
import tempfile

_FOLDER = pathlib.Path(__file__).with_name("native")
_FLAGS = ("-O3", "-march=native", "-fopenmp-simd", "-ffast-math", "-std=c++17", "-shared", "-fPIC")


def compiler() -> str | None:
    """A C++ compiler, if there is one."""
    return shutil.which("g++") or shutil.which("clang++")


def built(source: str, headers: dict[str, str] | None = None) -> ctypes.CDLL:
    """The library of a source file in `native`.

    **Arguments:**

    - `headers`: contents by name of those that are made for it.
    """
    path = compiler()
    assert path is not None
    with tempfile.TemporaryDirectory() as folder:
        for name, content in (headers or {}).items():
            (pathlib.Path(folder) / name).write_text(content)
        library = pathlib.Path(folder) / "peer.so"
        command = [path, *_FLAGS, f"-I{folder}", str(_FOLDER / source), "-o", str(library)]
        subprocess.run([*command, "-lpthread"], check=True)
        return ctypes.CDLL(str(library))
