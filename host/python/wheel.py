"""Makes the wheel: `python3 wheel.py LIBRARY FOLDER`, where LIBRARY is a libgts of this platform; it goes in.

The same files make the same wheel, byte for byte."""

import base64
import hashlib
import pathlib
import re
import sys
import sysconfig
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
LICENCES = ("LICENSE-MIT", "LICENSE-APACHE")


def version():
    text = (HERE / "beamtick" / "__init__.py").read_text(encoding="utf-8")
    return re.search(r'^__version__ = "(.*)"', text, re.M).group(1)


def make(library, folder):
    number = version()
    tag = f"py3-none-{re.sub('[-.]', '_', sysconfig.get_platform())}"
    about = f"beamtick-{number}.dist-info"
    files = {f"beamtick/{f.name}": f.read_bytes() for f in sorted((HERE / "beamtick").iterdir()) if f.suffix in (".py", ".pyi", ".typed")}
    files["beamtick/py.typed"] = b""
    files[f"beamtick/{library.name}"] = library.read_bytes()
    files[f"{about}/METADATA"] = (
        f"Metadata-Version: 2.1\nName: beamtick\nVersion: {number}\n"
        "Summary: Motion and laser controller Beamtick: the functions of libgts, with a virtual controller inside\n"
        "License: MIT OR Apache-2.0\nRequires-Python: >=3.9\n"
        "Provides-Extra: plot\nRequires-Dist: matplotlib ; extra == 'plot'\n"
        "Provides-Extra: pandas\nRequires-Dist: pandas ; extra == 'pandas'\n"
    ).encode()
    files[f"{about}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: beamtick\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    for name in LICENCES:
        files[f"{about}/licenses/{name}"] = (HERE.parents[1] / name).read_bytes()
    record = "".join(
        f"{name},sha256={base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b'=').decode()},{len(data)}\n"
        for name, data in files.items()
    )
    files[f"{about}/RECORD"] = (record + f"{about}/RECORD,,\n").encode()
    made = folder / f"beamtick-{number}-{tag}.whl"
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as wheel:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if name.endswith((".so", ".dylib", ".dll")) else 0o644) << 16
            wheel.writestr(entry, data)
    return made


if __name__ == "__main__":
    library, folder = map(pathlib.Path, sys.argv[1:])
    folder.mkdir(parents=True, exist_ok=True)
    print(make(library, folder))
