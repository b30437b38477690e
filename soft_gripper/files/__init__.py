"""Reads and writes files: text, YAML, JSON, XML, tables and folders of results.

Input is checked where it enters, and only there: bytes and text in `text` (regular files, bounded in size), YAML in
`yaml_text` and JSON in `json_text` (plain data, bounded in length, depth and count), both in `document` (finite
numbers; names, which become signals and files), XML in `xml_text` (no DOCTYPE, bounded in depth), numbers of models in
`model_import.drake_parsing`, before Drake, some of whose conditions end the process; the length of a run in
`scenario.checks`; output paths in `output`. Log messages and warnings of libraries become a `note:`, as does
what is mended or left out of a file (`notes`).
"""
