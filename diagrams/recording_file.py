"""Files of recordings: written as netCDF 4, which is HDF5, compressed; read as netCDF 3 too.

`live` still writes netCDF 3, to which rows can be appended so that the file is whole at any time.
"""

from pathlib import Path
from typing import Any

import xarray as xr
from xarray.backends import H5NetCDFStore

from soft_gripper.errors import InputError, first_line, shortened
from soft_gripper.files.document import require
from soft_gripper.files.text import check_regular

_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_SCIPY_OPTIONS = {"engine": "scipy"}
# How xarray opens files by their first bytes; axes without a name get one.
_READER_OPTIONS: dict[bytes, dict[str, Any]] = {
    **{b"CDF\x01": _SCIPY_OPTIONS, b"CDF\x02": _SCIPY_OPTIONS},
    _HDF5_SIGNATURE[:4]: {"engine": "h5netcdf", "phony_dims": "access"},
}
# Maximum size of the arrays in memory, as a multiple of the file size: text takes more, and those of a finger at rest
# seven times as much as compressed. Small files may hold more, such as zeros.
_MAX_EXPANSION = {"scipy": 8, "h5netcdf": 64}
_SMALL_SIZE = 64 * 2**20  # bytes in memory
# Form of HDF5 with checksums of its structures: without, damaged ones can read for ever.
_CHECKSUMMED_FORMAT = "v110", "v110"
_MIN_SUPERBLOCK_VERSION = 2  # first with checksums; the byte after the signature
_CHUNK_SAMPLES = 1000  # compressed together
_COMPRESSION_LEVEL = 1  # 4 saves another 3 %, and takes a tenth longer


def write_netcdf(data: xr.Dataset, path: Path) -> None:
    """Writes a netCDF 4 file, signal by signal, so that hardly more than one signal is in memory twice."""
    encoding = {name: _encoding(variable) for name, variable in data.variables.items()}
    # No lock but that of h5py: to find one xarray would import `distributed`, 0.2 s where it is installed.
    with H5NetCDFStore.open(path, "w", driver_kwds={"libver": _CHECKSUMMED_FORMAT}, lock=False) as store:
        data.drop_encoding().dump_to_store(store, encoding=encoding)


def _encoding(variable: xr.Variable) -> dict[str, Any]:
    if not variable.size or not variable.ndim or variable.dtype.kind not in "biuf":
        return {}
    chunks = (min(_CHUNK_SAMPLES, variable.shape[0]), *variable.shape[1:])
    return {"zlib": True, "complevel": _COMPRESSION_LEVEL, "shuffle": True, "chunksizes": chunks}


def read_netcdf(path: Path) -> xr.Dataset:
    """Reads a whole file.

    Raises:
        InputError: if the file does not exist, is not netCDF 3 or 4, or is damaged.
    """
    check_regular(path)
    try:
        with path.open("rb") as opened:
            begin = opened.read(len(_HDF5_SIGNATURE) + 1)
        require(begin[:4] in _READER_OPTIONS, path, "file", path.name, "is not a netCDF file of version 3 or 4")
        options = _READER_OPTIONS[begin[:4]]
        if begin.startswith(_HDF5_SIGNATURE):
            is_checked = begin[-1] >= _MIN_SUPERBLOCK_VERSION
            require(
                is_checked, path, "file", path.name, "is netCDF 4 without checksums; convert it with nccopy -k classic"
            )
            _check_hdf5(path)
        with xr.open_dataset(path, **options) as data:
            fits = data.nbytes <= max(_MAX_EXPANSION[options["engine"]] * path.stat().st_size, _SMALL_SIZE)
            require(fits, path, "size", data.nbytes, "is damaged: its arrays are larger than the file")
            return data.load()
    except InputError:
        raise
    except Exception as error:  # parsers do not document their exceptions
        expected = f"is a damaged netCDF file: {shortened(first_line(error), 100)}"
        raise InputError(path, "file", path.name, expected) from None


def _check_hdf5(path: Path) -> None:
    """Checks that the arrays of a file are in the file: HDF5 also reads others, even pipes, in their place."""
    import h5py  # takes a tenth of a second

    with h5py.File(path) as file:
        for name in file:
            is_inside = isinstance(file.get(name, getlink=True), h5py.HardLink)
            array = file[name] if is_inside else None
            if isinstance(array, h5py.Dataset):
                is_inside = not (array.is_virtual or array.external)
            require(is_inside, path, "array", name, "is kept in another file; copy it into this one")
