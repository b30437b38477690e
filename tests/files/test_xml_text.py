"""XML text of strangers is data: no entities, no other files, no nesting without end."""

import pytest
from refusals import refused

from soft_gripper.files.xml_text import check_counts, parse_xml, read_xml

BOMB = """<!DOCTYPE a [<!ENTITY x "xxxxxxxxxx"><!ENTITY y "&x;&x;&x;&x;&x;&x;&x;&x;&x;&x;">
<!ENTITY z "&y;&y;&y;&y;&y;&y;&y;&y;&y;&y;">]><a b="&z;"/>"""
OUTSIDE = '<!DOCTYPE a [<!ENTITY x SYSTEM "secret.txt">]><a>&x;</a>'


@pytest.mark.parametrize("text", [BOMB, OUTSIDE, "<!DOCTYPE a><a/>", '<!DOCTYPE a SYSTEM "a.dtd"><a/>'])
def test_a_doctype_is_refused(text):
    with refused("DOCTYPE", "a"):
        parse_xml("a.urdf", text)


@pytest.mark.parametrize("text", ["<a>", "", "<a>&x;</a>", "<a b='1' b='2'/>", "a\udc80b"])
def test_what_is_not_well_formed(text):
    with refused("file", "a.urdf"):
        parse_xml("a.urdf", text)


def test_nesting_ends_somewhere():
    parse_xml("a.urdf", "<a>" * 100 + "</a>" * 100)
    with refused("element", "b"):
        parse_xml("a.urdf", "<b>" * 100_000 + "</b>" * 100_000)


def test_elements_and_comments_are_kept(tmp_path):
    (tmp_path / "a.urdf").write_text('<?xml version="1.0"?>\n<a><!-- why --><b c="1"/></a>')
    root = read_xml(tmp_path / "a.urdf")
    assert [child.tag if isinstance(child.tag, str) else child.text for child in root] == [" why ", "b"]


def test_a_file_of_very_many_elements_is_refused():
    with refused("element", "l"):
        parse_xml("big.urdf", f"<robot>{60_000 * '<l/>'}</robot>")


def test_many_prefixes_are_declared():
    with refused("prefix", "p0"):
        parse_xml("a.urdf", f"<a>{''.join(f'<p{i}:x/>' for i in range(20_000))}</a>")


NAME = 5_000 * "n"


@pytest.mark.parametrize(
    ("text", "field", "value"),
    [
        (f"<a name='{NAME}'/>", "a.name", NAME),
        (f"<a model='{5_000 * '1 '}'/>", "a.model", 5_000 * "1 "),
        (f"<a {NAME}='1'/>", f"a.{NAME}", NAME),
        (f"<{NAME}/>", NAME, NAME),
    ],
)
def test_names_have_a_length(text, field, value):
    with refused(field, value):
        parse_xml("a.urdf", text)


def test_texts_have_a_length():
    with refused("file", "a.urdf"):
        parse_xml("a.urdf", f"<a>{9_000_000 * ' '}</a>")


def test_elements_have_few_attributes():
    with refused("attributes of <a>", 300):
        parse_xml("a.urdf", "<a " + " ".join(f"a{i}='1'" for i in range(300)) + "/>")


@pytest.mark.parametrize(("tag", "most"), [("link", 500), ("body", 500), ("joint", 1500), ("geom", 2500)])
def test_models_have_a_size(tag, most):
    check_counts("a.xml", parse_xml("a.xml", f"<m>{most * f'<{tag}/>'}</m>"))
    with refused(f"<{tag}>", most + 1):
        check_counts("a.xml", parse_xml("a.xml", f"<m>{(most + 1) * f'<{tag}/>'}</m>"))


def test_links_have_some_shapes():
    link = f"<link name='l'><visual/>{501 * '<collision/>'}</link>"
    with refused("shapes", 501):
        check_counts("a.urdf", parse_xml("a.urdf", f"<robot>{link}</robot>"))
