"""Recognizes files of other programs that are not read, and says how to export them: a table line for each format."""

from collections.abc import Sequence

_AS_CSV = "export it as text with commas"
_BINARY_FORMS: tuple[tuple[bytes, str], ...] = (  # how a file begins
    (b"MATLAB 7.3", 'is a MATLAB 7.3 file: in MATLAB, writetable(struct2table(load("log.mat")), "log.csv")'),
    (b"MATLAB 5.0", 'is a MATLAB 5 file: in MATLAB, writetable(struct2table(load("log.mat")), "log.csv")'),
    (b"\x89HDF\r\n\x1a\n", f"is HDF5: {_AS_CSV}; netCDF 4 is converted by nccopy -k classic"),
    (b"PK\x03\x04", f"is a workbook of a spreadsheet, or another zip archive: {_AS_CSV}; of an .npz, numpy.savetxt"),
    (b"\xd0\xcf\x11\xe0", f"is a workbook of an old spreadsheet: {_AS_CSV}"),
    (b"\x93NUMPY", 'is an array of NumPy: numpy.savetxt("log.csv", array, delimiter=",", header="t,a,b")'),
    (b"PAR1", 'is Parquet: pandas.read_parquet(file).to_csv("log.csv")'),
    (b"ARROW1", 'is Feather: pandas.read_feather(file).to_csv("log.csv")'),
    (b"TDSm", f"is TDMS of LabVIEW: {_AS_CSV}, in LabVIEW or with npTDMS"),
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
    (b"%PDF", f"is a PDF: {_AS_CSV}"),
    (b"{\\rtf", f"is a document of a word processor: {_AS_CSV}"),
    (b"\x80\x04\x95", f"is a pickle of Python, which can run code and is not opened: {_AS_CSV}"),
    (b"\x80\x05\x95", f"is a pickle of Python, which can run code and is not opened: {_AS_CSV}"),
)
_HDF5_HEAD = b"\x89HDF\r\n\x1a\n"
_BY_HEADER = "export a C3D file, or name its columns in `header` of the description"
_TEXT_FORMS: tuple[tuple[str, str], ...] = (
    ("Format Version,", f"is an export of Motive, whose columns are named over several lines: {_BY_HEADER}"),
    ("PathFileType", f"is a TRC file of motion capture, whose columns are named over two lines: {_BY_HEADER}"),
    ("NO_OF_FRAMES", f"is an export of Qualisys, whose columns are named over several lines: {_BY_HEADER}"),
    ("Trajectories", f"is an export of Vicon Nexus, whose columns are named over several lines: {_BY_HEADER}"),
    ("Devices", f"is an export of Vicon Nexus, whose columns are named over several lines: {_BY_HEADER}"),
    ("<", f"is XML or HTML: {_AS_CSV}"),
    ("%YAML", f"is YAML: {_AS_CSV}"),
    ("---", f"is YAML: {_AS_CSV}"),
)


def foreign_binary(data: bytes) -> str | None:
    """Format of a binary file and its export, in words; None: unknown."""
    binary_form = next((description for begin, description in _BINARY_FORMS if data.startswith(begin)), None)
    return binary_form or (dict(_BINARY_FORMS)[_HDF5_HEAD] if data[512:].startswith(_HDF5_HEAD) else None)


def foreign_text(lines: Sequence[str]) -> str | None:
    """Format of a text file without the columns and its export, in words; None: unknown."""
    first_line = next((line.lstrip(' "') for line in lines if line.strip()), "")
    return next((format_text for begin, format_text in _TEXT_FORMS if first_line.startswith(begin)), None)
