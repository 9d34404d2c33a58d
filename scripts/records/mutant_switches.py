"""Puts mutants into Rust sources, each behind a switch, so that one build holds them all.

An operator `a + b` with the mutant 7 becomes `(if crate::mutants::active(7) { a - b } else { a + b })`, a
function's body begins with `if crate::mutants::active(8) { return REPLACEMENT; }`. No line moves, so the line of a
compiler error shows which mutants do not compile.
"""

import tree_sitter_rust
from tree_sitter import Language, Parser

# Upper limit of the numbers.
MOST = 8192

SWITCH = f"""\
//! Which mutant is switched on: ATLAS_MUTANT. Where that is `trace`, none is, and the numbers of those that
//! are reached are added to the file ATLAS_MUTANTS_REACHED, a line each.
use std::fs::OpenOptions;
use std::io::Write;
use std::sync::LazyLock;
use std::sync::atomic::{{AtomicBool, Ordering}};
const TRACE: u32 = u32::MAX;
static ACTIVE: LazyLock<u32> = LazyLock::new(|| match std::env::var("ATLAS_MUTANT") {{
    Ok(text) if text == "trace" => TRACE,
    Ok(text) => text.parse().unwrap_or(0),
    Err(_) => 0,
}});
static SEEN: [AtomicBool; {MOST}] = [const {{ AtomicBool::new(false) }}; {MOST}];
/// Whether it is this one.
#[inline(always)]
pub fn active(mutant: u32) -> bool {{
    let active = *ACTIVE;
    if active == TRACE && !SEEN[mutant as usize].load(Ordering::Relaxed) {{
        reached(mutant);
    }}
    active == mutant
}}
#[cold]
fn reached(mutant: u32) {{
    if !SEEN[mutant as usize].swap(true, Ordering::Relaxed) {{
        let Ok(path) = std::env::var("ATLAS_MUTANTS_REACHED") else {{ return }};
        let mut file = OpenOptions::new().create(true).append(true).open(path).expect("a file");
        file.write_all(format!("{{mutant}}\\n").as_bytes()).expect("a file");
    }}
}}
"""

# Replacements of operators, as in cargo-mutants.
OPERATORS = {
    "==": ["!="],
    "!=": ["=="],
    "&&": ["||"],
    "||": ["&&"],
    "<": ["==", ">", "<="],
    ">": ["==", "<", ">="],
    "<=": [">"],
    ">=": ["<"],
    "+": ["-", "*"],
    "-": ["+", "/"],
    "*": ["+", "/"],
    "/": ["%", "*"],
    "%": ["/", "+"],
    "<<": [">>"],
    ">>": ["<<"],
    "&": ["|", "^"],
    "|": ["&", "^"],
    "^": ["|", "&"],
    "+=": ["-=", "*="],
    "-=": ["+=", "/="],
    "*=": ["+=", "/="],
    "/=": ["%=", "*="],
}

# Replacements of returned values by type. Other types have their default, if there is one.
VALUES = {
    "": ["()"],
    "bool": ["true", "false"],
    "f64": ["0.0", "1.0", "-1.0"],
    "String": ["String::new()", "String::from(\"xyzzy\")"],
    "&str": ["\"\"", "\"xyzzy\""],
    "&'static str": ["\"\"", "\"xyzzy\""],
    **{whole: ["0", "1"] for whole in ["usize", "u8", "u32", "u64"]},
    **{whole: ["0", "1", "-1"] for whole in ["i8", "i32", "i64"]},
}
EXPRESSIONS = {"binary_expression", "compound_assignment_expr", "unary_expression"}

_parser = Parser(Language(tree_sitter_rust.language()))


def _values(returned):
    """Replacements of a function's value by its type."""
    if returned in VALUES:
        return VALUES[returned]
    if returned.startswith("Option<"):
        return ["None"]
    if returned.startswith("Result<"):
        return ["Ok(Default::default())"]
    return ["Default::default()"]


def _is_test(node, source):
    """Whether an attribute restricts an item to tests."""
    before = node.prev_named_sibling
    while before is not None and before.type in {"attribute_item", "line_comment"}:
        if b"cfg(test)" in before.text or before.text == b"#[test]":
            return True
        before = before.prev_named_sibling
    return False


def listed(source, name):
    """The mutants of a source file: places and replacements."""
    mutants = []

    def add(node, kind, at, replacement, what):
        row, column = at.start_point
        mutants.append(
            {
                "place": (node.start_byte, node.end_byte, node.type),
                "rows": (node.start_point[0] + 1, node.end_point[0] + 1),
                "kind": kind,
                "file": name,
                "replacement": replacement,
                "name": f"{name}:{row + 1}:{column + 1}: {what}",
            }
        )

    def visit(node, function):
        if node.type in {"function_item", "mod_item"} and _is_test(node, source):
            return
        if node.type == "function_item":
            body, returned = node.child_by_field_name("body"), node.child_by_field_name("return_type")
            function = node.child_by_field_name("name").text.decode()
            returned = returned.text.decode() if returned is not None else ""
            modifiers = b" ".join(c.text for c in node.children if c.type == "function_modifiers")
            if b"const" not in modifiers and b"unsafe" not in modifiers and body.named_child_count:
                for value in _values(returned):
                    add(body, "value", node, value, f"{function} gives {value}")
                    # The compiler reports an error of the value at the opening brace.
                    mutants[-1]["rows"] = (body.start_point[0] + 1,) * 2
        if node.type in {"binary_expression", "compound_assignment_expr"}:
            operator = node.child_by_field_name("operator")
            for other in OPERATORS.get(operator.text.decode(), []):
                what = f"{operator.text.decode()} becomes {other} in {function}"
                add(node, "operator", operator, other, what)
        if node.type == "unary_expression" and node.children[0].text in {b"-", b"!"}:
            what = f"{node.children[0].text.decode()} is left out in {function}"
            add(node, "operator", node, "", what)
        if node.type == "match_block":
            arms = [child for child in node.children if child.type == "match_arm"]
            patterns = [arm.child_by_field_name("pattern") for arm in arms]
            for arm, pattern in zip(arms, patterns):
                guard = pattern.child_by_field_name("condition")
                if guard is not None:
                    for value in ["true", "false"]:
                        add(arm, "guard", guard, value, f"a guard is {value} in {function}")
                elif any(other.text == b"_" for other in patterns) and pattern.text != b"_":
                    what = f"the arm {pattern.text.decode()[:40]} is left out in {function}"
                    add(arm, "arm", arm, "", " ".join(what.split()))
        for child in node.children:
            visit(child, function)

    visit(_parser.parse(source).root_node, "the file")
    return mutants


class Switched:
    """A source file with mutants."""

    def __init__(self, source, mutants):
        self.source = source
        self.places = {}
        for mutant in mutants:
            self.places.setdefault(mutant["place"], []).append(mutant)

    def text(self):
        """The file with the switches."""
        return self._render(_parser.parse(self.source).root_node)

    def _slice(self, node):
        return self.source[node.start_byte : node.end_byte].decode()

    def _changed(self, node, mutant):
        """The replacement of an expression by its active mutant, on one line."""
        if node.type == "unary_expression":
            operand = node.children[-1]
            text = self._slice(operand)
        else:
            left, operator, right = (node.child_by_field_name(f) for f in ("left", "operator", "right"))
            text = f"{self._slice(left)} {mutant['replacement']} {self._slice(right)}"
        # Without comments and line ends, so that no line moves.
        return " ".join(line.split("//")[0] for line in text.split("\n"))

    def _render(self, node):
        mutants = self.places.get((node.start_byte, node.end_byte, node.type), [])
        pieces, at = [], node.start_byte
        for child in node.children:
            pieces.append(self.source[at : child.start_byte].decode())
            rendered = self._render(child)
            if child.type == "match_pattern" and node.type == "match_arm":
                rendered = self._arm(child, rendered, mutants)
            pieces.append(rendered)
            if node.type == "block" and child.type == "{":
                pieces += [
                    f" if crate::mutants::active({m['number']}) {{ return {m['replacement']}; }} "
                    for m in mutants
                ]
            at = child.end_byte
        text = "".join(pieces) + self.source[at : node.end_byte].decode()
        if node.type in EXPRESSIONS and mutants:
            for mutant in mutants:
                changed = self._changed(node, mutant)
                text = f"if crate::mutants::active({mutant['number']}) {{ {changed} }} else {{ {text} }}"
            text = f"({text})"
        return text

    @staticmethod
    def _arm(pattern, rendered, mutants):
        """A pattern with its guard: the guard is replaced, or the arm is skipped."""
        guard = pattern.child_by_field_name("condition")
        for mutant in mutants:
            switch = f"crate::mutants::active({mutant['number']})"
            if mutant["kind"] == "arm":
                if guard is None and " if " not in rendered:
                    rendered = f"{rendered} if !{switch}"
                else:
                    head, tail = rendered.split(" if ", 1)
                    rendered = f"{head} if !{switch} && ({tail})"
            else:
                head, tail = rendered.split(" if ", 1)
                value = mutant["replacement"]
                rendered = f"{head} if (if {switch} {{ {value} }} else {{ {tail} }})"
        return rendered
