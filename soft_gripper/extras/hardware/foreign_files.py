"""Files of other programs that are not read: what they are, and how their data are exported."""

from collections.abc import Sequence

_CSV = "export it as text with commas"
_BINARY: tuple[tuple[bytes, str], ...] = (  # how a file begins
    (b"MATLAB 7.3", 'is a MATLAB 7.3 file: in MATLAB, writetable(struct2table(load("log.mat")), "log.csv")'),
    (b"MATLAB 5.0", 'is a MATLAB 5 file: in MATLAB, writetable(struct2table(load("log.mat")), "log.csv")'),
    (b"\x89HDF\r\n\x1a\n", f"is HDF5: {_CSV}; netCDF 4 is converted by nccopy -k classic"),
    (b"PK\x03\x04", f"is a workbook of a spreadsheet, or another zip archive: {_CSV}; of an .npz, numpy.savetxt"),
    (b"\xd0\xcf\x11\xe0", f"is a workbook of an old spreadsheet: {_CSV}"),
    (b"\x93NUMPY", 'is an array of NumPy: numpy.savetxt("log.csv", array, delimiter=",", header="t,a,b")'),
    (b"PAR1", 'is Parquet: pandas.read_parquet(file).to_csv("log.csv")'),
    (b"ARROW1", 'is Feather: pandas.read_feather(file).to_csv("log.csv")'),
    (b"TDSm", f"is TDMS of LabVIEW: {_CSV}, in LabVIEW or with npTDMS"),
    (b"ULog", "is a log of PX4: ulog2csv converts it"),
    (b"#ROSBAG", "is a bag of ROS: name it .bag"),
    (b"\x89MCAP", "is an MCAP file: name it .mcap"),
    (b"SQLite format 3", "is a database; the bag of ROS 2 is named .db3"),
    (b"CDF\x01", "is netCDF: name it .nc"),
    (b"CDF\x02", "is netCDF: name it .nc"),
    (b"\x1f\x8b", "is compressed: unpack it, as gunzip does"),
    (b"BZh", "is compressed: unpack it, as bunzip2 does"),
    (b"\xfd7zXZ", "is compressed: unpack it, as unxz does"),
    (b"\x28\xb5\x2f\xfd", "is compressed: unpack it, as unzstd does"),
    (b"%PDF", f"is a PDF: {_CSV}"),
    (b"{\\rtf", f"is a document of a word processor: {_CSV}"),
    (b"\x80\x04\x95", f"is a pickle of Python, which can run code and is not opened: {_CSV}"),
    (b"\x80\x05\x95", f"is a pickle of Python, which can run code and is not opened: {_CSV}"),
)
_HDF5 = b"\x89HDF\r\n\x1a\n"
_OR_NAMED = "export a C3D file, or name its columns in `header` of the description"
_TEXT: tuple[tuple[str, str], ...] = (
    ("Format Version,", f"is an export of Motive, whose columns are named over several lines: {_OR_NAMED}"),
    ("PathFileType", f"is a TRC file of motion capture, whose columns are named over two lines: {_OR_NAMED}"),
    ("NO_OF_FRAMES", f"is an export of Qualisys, whose columns are named over several lines: {_OR_NAMED}"),
    ("Trajectories", f"is an export of Vicon Nexus, whose columns are named over several lines: {_OR_NAMED}"),
    ("Devices", f"is an export of Vicon Nexus, whose columns are named over several lines: {_OR_NAMED}"),
    ("<", f"is XML or HTML: {_CSV}"),
    ("%YAML", f"is YAML: {_CSV}"),
    ("---", f"is YAML: {_CSV}"),
)


def foreign_binary(data: bytes) -> str | None:
    """Kind of a file of bytes, and how it is exported; None if it is none of those that are known."""
    begins = next((form for begin, form in _BINARY if data.startswith(begin)), None)
    return begins or (dict(_BINARY)[_HDF5] if data[512:].startswith(_HDF5) else None)


def foreign_text(lines: Sequence[str]) -> str | None:
    """Kind of a file of text whose columns are not found; None if it is none of those that are known."""
    first = next((line.lstrip(' "') for line in lines if line.strip()), "")
    return next((form for begin, form in _TEXT if first.startswith(begin)), None)
