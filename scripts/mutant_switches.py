"""Puts mutants into Rust sources, each behind a switch, so that one build holds them all.

An operator `a + b` with the mutant 7 becomes `(if crate::mutants::active(7) { a - b } else { a + b })`, a
function's body begins with `if crate::mutants::active(8) { return REPLACEMENT; }`. No line moves, so that an
error of the compiler at a line tells which mutants do not compile.
"""

import tree_sitter_rust
from tree_sitter import Language, Parser

SWITCH = """\
//! Which mutant is switched on: ATLAS_MUTANT.
use std::sync::LazyLock;
static ACTIVE: LazyLock<u32> = LazyLock::new(|| {
    std::env::var("ATLAS_MUTANT").ok().and_then(|text| text.parse().ok()).unwrap_or(0)
});
/// Whether it is this one.
#[inline(always)]
pub fn active(mutant: u32) -> bool {
    *ACTIVE == mutant
}
"""

# What cargo-mutants calls the kinds that can be switched. Deleted fields of structs are left out: the value
# in their place is that of another expression.
KINDS = {"FnValue", "BinaryOperator", "UnaryOperator", "MatchArm", "MatchArmGuard"}
EXPRESSIONS = {"binary_expression", "compound_assignment_expr", "unary_expression"}

_parser = Parser(Language(tree_sitter_rust.language()))


class Unfit(Exception):
    """A mutant that cannot be switched."""


def _ancestor(node, kinds):
    while node is not None and node.type not in kinds:
        node = node.parent
    if node is None:
        raise Unfit("not found in the source")
    return node


def _place(node, mutant):
    """The node that a mutant changes."""
    match mutant["genre"]:
        case "FnValue":
            function = _ancestor(node, {"function_item"})
            modifiers = [c for c in function.children if c.type == "function_modifiers"]
            if any(b"const" in c.text for c in modifiers):
                raise Unfit("a constant function")
            return function.child_by_field_name("body")
        case "BinaryOperator" | "UnaryOperator":
            return _ancestor(node, EXPRESSIONS)
        case _:
            return _ancestor(node, {"match_arm"})


class Switched:
    """A source file with mutants."""

    def __init__(self, source, mutants):
        self.source = source
        self.tree = _parser.parse(source)
        self.places = {}
        self.unfit = {}
        lines = source.decode().split("\n")
        for mutant in mutants:
            line, column = mutant["span"]["start"]["line"], mutant["span"]["start"]["column"]
            byte = len(lines[line - 1][: column - 1].encode())
            leaf = self.tree.root_node.descendant_for_point_range((line - 1, byte), (line - 1, byte + 1))
            try:
                node = _place(leaf, mutant)
                self._changed(node, mutant)
            except Unfit as why:
                self.unfit[mutant["number"]] = str(why)
                continue
            rows = (node.start_point[0] + 1, node.end_point[0] + 1)
            if mutant["genre"] == "FnValue":
                # An error of a replacement is told at the opening brace.
                rows = (rows[0], rows[0])
            mutant["rows"] = rows
            self.places.setdefault((node.start_byte, node.end_byte, node.type), []).append(mutant)

    def text(self):
        """The file with the switches."""
        return self._render(self.tree.root_node)

    def _slice(self, node):
        return self.source[node.start_byte : node.end_byte].decode()

    def _changed(self, node, mutant):
        """What stands in the place of an expression where its mutant is active, on one line."""
        if node.type not in EXPRESSIONS:
            return None
        if node.type == "unary_expression":
            operand = node.children[-1]
            text = self._slice(operand)
        else:
            left, operator, right = (node.child_by_field_name(f) for f in ("left", "operator", "right"))
            if operator is None:
                raise Unfit("no operator")
            text = f"{self._slice(left)} {mutant['replacement']} {self._slice(right)}"
        if "//" in text:
            raise Unfit("a comment inside")
        return " ".join(text.split("\n"))

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
        """A pattern with its guard: the guard replaced, or the arm passed over."""
        guard = pattern.child_by_field_name("condition")
        for mutant in mutants:
            switch = f"crate::mutants::active({mutant['number']})"
            if mutant["genre"] == "MatchArm":
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
