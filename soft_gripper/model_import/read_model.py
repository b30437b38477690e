"""Reads a model file of any form into an `ImportedModel`, which Drake takes.

A form is a module of `forms` with a `FORM`; a file of no form is left to Drake.
"""

import pkgutil
import xml.etree.ElementTree as ET
from importlib import import_module

from soft_gripper.errors import InputError
from soft_gripper.model_import import forms
from soft_gripper.model_import.added_model import model_mass
from soft_gripper.model_import.imported_model import Form, ImportedModel, ImportOptions
from soft_gripper.model_import.model_file import ModelFile

_XML_SUFFIXES = (".urdf", ".xacro", ".sdf", ".world", ".xml", ".mjcf")
_NO_OPTIONS = ImportOptions()
_FORM_MODULES = sorted((module.name for module in pkgutil.iter_modules(forms.__path__)), reverse=True)
FORMS: list[Form] = [import_module(f"{forms.__name__}.{name}").FORM for name in _FORM_MODULES]
_BY_MARK = {mark: form for form in FORMS for mark in form.marks}


def form_of(file: ModelFile) -> Form | None:
    """The form of a file; None if Drake alone may know it. Raises an InputError if it is XML of no known form."""
    suffix = file.path.suffix.lower()
    if suffix not in _XML_SUFFIXES:
        return _BY_MARK.get(suffix)
    if file.root.tag not in _BY_MARK:
        marks = ", ".join(f"<{mark}> ({form.name})" for mark, form in _BY_MARK.items() if not mark.startswith("."))
        file.refuse("root element", file.root.tag, f"a model begins with one of {marks}")
    return _BY_MARK[file.root.tag]


def has_form(file: ModelFile, name: str) -> bool:
    """Whether a file has the form with a name; raises as `form_of`."""
    form = form_of(file)
    return form is not None and form.name == name


def read_model(file: ModelFile, options: ImportOptions = _NO_OPTIONS) -> ImportedModel:
    """Reads a model as Drake can simulate it, an arm, a gripper or an object; keeps elements that Drake understands.

    Its elements are changed; the notes on that are those of the file.

    Raises:
        InputError: if it cannot be read, a file that it names is missing, or it contradicts itself or the options.
    """
    form = form_of(file)
    if options.without and (form is None or form.scale is None):
        expected = f"links can be left out of {', '.join(form.name for form in FORMS if form.scale)} only"
        raise InputError(options.where, "without", options.without, expected)
    if form is None:
        return ImportedModel(None, friction=options.friction)
    imported = form.read(file, options)
    if form.scale is None:
        return imported
    text = imported.text or ""
    if options.mass is not None:
        old_mass = model_mass(file, text, imported.suffix)
        if not old_mass > 0:
            expected = f"leave it out: {file.path.name} has no rigid link with a mass to change"
            raise InputError(options.where, "mass", options.mass, expected)
        root = ET.fromstring(text)
        form.scale(file.path, root, options.mass / old_mass)
        text = ET.tostring(root, encoding="unicode")
    return imported._replace(text=text, friction=options.friction)
