//! Does the code follow its architecture? The test reads layers, printing, file sizes and unsafe code from the sources.
//! Every rule is also tested with a planted violation.

#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A module may import from layers above its own line, and from itself; each crate below `src` has some layers.
const LAYERS: [&[&str]; 13] = [
    &["units", "numerics", "topology", "input"],
    &["structure"],
    &["model"],
    &["propagate", "reference"],
    // The kernels of the paper.
    &["analysis", "attachment", "kernels"],
    &["gear"],
    // A shaft carries gears.
    &["shaft"],
    &["manifest", "store"],
    &["sweep"],
    &["characterize", "fmu"],
    &["verify"],
    &["report", "export", "ladder"],
    &["cli"],
];

/// The reference integrator shares no code with the kernels: it may import only these modules. Its tests may build
/// models.
const REFERENCE_KNOWS: [&str; 1] = ["model"];

/// Largest number of lines in a file, without tests.
const LONGEST: usize = 500;

/// Files that need unsafe code: calls of functions compiled for a detected instruction set; raw memory, addresses and
/// vectors in measurements; exported C functions and their arguments.
const UNSAFE: [&str; 8] = [
    "propagate/vectors/mod.rs",
    "propagate/vectors/halves.rs",
    "propagate/vectors/wide.rs",
    "characterize/buffer.rs",
    "characterize/chain.rs",
    "characterize/vectors.rs",
    "export.rs",
    "foreign.rs",
];

/// Macros and functions that only the command line may use.
const OUTWARD: [&str; 9] = [
    "print!(",
    "println!(",
    "eprint!(",
    "eprintln!(",
    "dbg!(",
    "stdout()",
    "stderr()",
    "process::exit",
    "ExitCode",
];

/// A source file, by its path below the folder of its crate with forward slashes.
struct Source {
    path: String,
    text: String,
}

impl Source {
    /// Top-level module of the file; `None` for the crate's roots.
    fn module(&self) -> Option<&str> {
        let (module, _) = self.path.split_once('/')?;
        Some(module)
    }

    fn is_test(&self) -> bool {
        self.path.ends_with("/tests.rs") || self.path.contains("/tests/")
    }

    /// The lines before the inline tests.
    fn lines(&self) -> impl Iterator<Item = &str> {
        let test = |line: &&str| line.trim_start().starts_with("#[cfg(test)]");
        self.text.lines().take_while(move |line| !test(line))
    }

    /// Top-level modules that the file names, including tests.
    fn imports(&self) -> Vec<String> {
        imports(self.text.lines())
    }

    /// Top-level modules that the file names outside its tests.
    fn working_imports(&self) -> Vec<String> {
        if self.is_test() { Vec::new() } else { imports(self.lines()) }
    }
}

/// A text without comments.
fn code<'a>(lines: impl Iterator<Item = &'a str>) -> String {
    let strip = |line: &str| line.split("//").next().unwrap().to_owned();
    lines.map(strip).collect::<Vec<_>>().join("\n")
}

/// Top-level modules that some lines name.
fn imports<'a>(lines: impl Iterator<Item = &'a str>) -> Vec<String> {
    let code = code(lines);
    let mut names = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        // Neither `$crate::` nor `other_crate::` refers to this crate's root.
        if code[..at].ends_with(|c: char| c.is_alphanumeric() || "_$".contains(c)) {
            continue;
        }
        let rest = &code[at + "crate::".len()..];
        match rest.strip_prefix('{') {
            Some(group) => names.extend(group_heads(group)),
            None => names.push(head(rest)),
        }
    }
    names
}

/// The identifier a text starts with.
fn head(text: &str) -> String {
    let end = text.find(|c: char| !(c.is_alphanumeric() || c == '_'));
    text[..end.unwrap_or(text.len())].to_owned()
}

/// First identifiers of the entries of `a::b, c::{d, e}}…`.
fn group_heads(group: &str) -> Vec<String> {
    let mut depth = 0;
    let mut heads = vec![head(group.trim_start())];
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => heads.push(head(group[at + 1..].trim_start())),
            _ => {}
        }
    }
    heads.retain(|h| !h.is_empty());
    heads
}

fn layer(module: &str) -> Option<usize> {
    LAYERS.iter().position(|layer| layer.contains(&module))
}

fn layer_offences(source: &Source) -> Vec<String> {
    let Some(module) = source.module() else {
        return Vec::new();
    };
    let Some(own) = layer(module) else {
        return vec![format!("{}: module {module} has no layer", source.path)];
    };
    let lower = |name: &str| layer(name).is_some_and(|l| l < own);
    let mut offenders = source.imports();
    offenders.retain(|name| name != module && !lower(name));
    if module == "reference" {
        let mut known = source.working_imports();
        known.retain(|name| {
            name != module && lower(name) && !REFERENCE_KNOWS.contains(&name.as_str())
        });
        offenders.append(&mut known);
    }
    let offend = |name: String| format!("{} imports {name}", source.path);
    offenders.into_iter().map(offend).collect()
}

fn outward_offences(source: &Source) -> Vec<String> {
    if source.module() == Some("cli") || source.path == "main.rs" || source.is_test() {
        return Vec::new();
    }
    let mut offences = Vec::new();
    for (i, line) in source.lines().enumerate() {
        let code = line.split("//").next().unwrap();
        // A longer macro name (`println!`) also ends in a shorter one; one finding is enough. A method with that name
        // is allowed.
        let outward = |word: &&&str| {
            code.match_indices(**word)
                .any(|(at, _)| !code[..at].ends_with('.'))
        };
        if let Some(word) = OUTWARD.iter().find(outward) {
            offences.push(format!("{}:{}: {word}", source.path, i + 1));
        }
    }
    offences
}

fn size_offences(source: &Source) -> Vec<String> {
    let lines = source.lines().count();
    if source.is_test() || lines <= LONGEST {
        return Vec::new();
    }
    vec![format!("{} has {lines} lines without tests", source.path)]
}

fn unsafe_offences(source: &Source) -> Vec<String> {
    let lines: Vec<&str> = source.text.lines().collect();
    let mut offences = Vec::new();
    for (i, line) in lines.iter().enumerate() {
        let code = line.split("//").next().unwrap();
        let words = |c: char| !(c.is_alphanumeric() || c == '_');
        if !code.split(words).any(|word| word == "unsafe") {
            continue;
        }
        let above = lines[i.saturating_sub(4)..i].iter();
        if !UNSAFE.contains(&source.path.as_str()) {
            offences.push(format!("{}:{}: unsafe code", source.path, i + 1));
        } else if !above.rev().any(|l| l.contains("// SAFETY: ")) {
            offences.push(format!("{}:{}: no SAFETY line", source.path, i + 1));
        }
    }
    offences
}

/// A file as a module: `report::plot` of `report/plot/mod.rs`.
fn module_path(path: &str) -> String {
    let stem = path.trim_end_matches(".rs").trim_end_matches("/mod");
    stem.replace('/', "::")
}

/// Every path of a `use` without blanks, with `a::{b, c::{d, e}}` split up.
fn paths(tree: &str) -> Vec<String> {
    let Some((prefix, group)) = tree.split_once('{') else {
        return vec![tree.split('@').next().unwrap().to_owned()];
    };
    let (mut depth, mut from, mut all) = (0, 0, Vec::new());
    for (at, c) in group.char_indices() {
        if depth == 0 && (c == ',' || c == '}') {
            let inner = paths(&group[from..at]).into_iter();
            all.extend(inner.map(|path| format!("{prefix}{path}")));
            from = at + 1;
        }
        depth += i32::from(c == '{') - i32::from(c == '}');
    }
    all
}

/// Imports of a file outside its tests, as paths from the crate's root, and whether it re-exports them.
fn uses(source: &Source) -> Vec<(String, bool)> {
    let here = module_path(&source.path);
    let parent = |path: &str| path.rsplit_once("::").map_or("", |(p, _)| p).to_owned();
    let mut found = Vec::new();
    for statement in code(source.lines()).split(';') {
        let Some((before, tree)) = statement.rsplit_once("use ") else {
            continue;
        };
        let public = before.lines().last().unwrap_or("").contains("pub");
        let tree = tree.replace(" as ", "@");
        let tree: String = tree.split_whitespace().collect();
        for path in paths(&tree) {
            let (mut base, mut rest) = (here.clone(), path.as_str());
            while let Some(above) = rest.strip_prefix("super::") {
                (base, rest) = (parent(&base), above);
            }
            found.push(match rest.strip_prefix("crate::") {
                Some(absolute) => (absolute.to_owned(), public),
                None => (
                    format!("{base}::{}", rest.trim_start_matches("self::")),
                    public,
                ),
            });
        }
    }
    found
}

/// Files of one module whose `use` statements import each other in circles, each with its imports that lead back to it.
/// A re-exported name counts as an import from its definition.
fn circles(sources: &[Source]) -> Vec<String> {
    let own = |s: &&Source| s.module().is_some() && !s.is_test() && !s.path.ends_with("_tests.rs");
    let files: BTreeMap<String, Vec<(String, bool)>> = (sources.iter().filter(own))
        .map(|source| (module_path(&source.path), uses(source)))
        .collect();
    let file_of = |path: &str| -> Option<&str> {
        let ends = path.rmatch_indices("::").map(|(at, _)| at);
        let mut prefixes = std::iter::once(path.len())
            .chain(ends)
            .map(|end| &path[..end]);
        let found = prefixes.find_map(|prefix| files.get_key_value(prefix))?;
        Some(found.0)
    };
    let home = |path: &str| -> Option<&str> {
        let name = &path[path.rfind("::")?..];
        let mut file = file_of(path)?;
        // A few re-exports at most.
        for _ in 0..5 {
            let handed_on = |(path, public): &&(String, bool)| *public && path.ends_with(name);
            let mut handed_on = files[file].iter().filter(handed_on);
            match handed_on.find_map(|(path, _)| file_of(path).filter(|next| *next != file)) {
                Some(next) => file = next,
                None => break,
            }
        }
        Some(file)
    };
    let imports = |file: &str| -> BTreeSet<&str> {
        let (below, module) = (format!("{file}::"), head(file));
        let used = files[file].iter();
        let used = used.filter(|(path, public)| !(*public && path.starts_with(&below)));
        let homes = used.filter_map(|(path, _)| home(path));
        homes
            .filter(|other| *other != file && head(other) == module)
            .collect()
    };
    let graph: BTreeMap<&str, BTreeSet<&str>> = files
        .keys()
        .map(|file| (file.as_str(), imports(file)))
        .collect();
    let leads = |from: &str, to: &str| {
        let (mut seen, mut open) = (BTreeSet::from([from]), vec![from]);
        while let Some(file) = open.pop() {
            open.extend(graph[file].iter().filter(|next| seen.insert(**next)));
        }
        seen.contains(to)
    };
    let back = |(file, imported): (&&str, &BTreeSet<&str>)| {
        let back: Vec<&str> = imported
            .iter()
            .copied()
            .filter(|next| leads(next, file))
            .collect();
        (!back.is_empty()).then(|| format!("{file} <-> {}", back.join(", ")))
    };
    graph.iter().filter_map(back).collect()
}

fn sources() -> Vec<Source> {
    let mut sources = sources_below("src");
    assert!(sources.len() > 50, "the sources were not found");
    for source in &mut sources {
        let (_, below) = source.path.split_once('/').unwrap();
        source.path = below.to_owned();
    }
    // Test programs of a crate are not among its modules.
    sources.retain(|source| !source.path.starts_with("tests/"));
    sources
}

/// The sources of the Python package, as a module called `python`.
fn python_sources() -> Vec<Source> {
    let mut sources = sources_below("python/src");
    assert!(sources.len() > 5, "the sources were not found");
    for source in &mut sources {
        source.path = format!("python/{}", source.path);
    }
    sources
}

fn sources_below(folder: &str) -> Vec<Source> {
    fn walk(folder: &Path, root: &Path, sources: &mut Vec<Source>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, root, sources);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let below = path.strip_prefix(root).unwrap();
                let parts = below.iter().map(|p| p.to_str().unwrap());
                sources.push(Source {
                    path: parts.collect::<Vec<_>>().join("/"),
                    text: std::fs::read_to_string(&path).unwrap(),
                });
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut sources = Vec::new();
    walk(&root, &root, &mut sources);
    sources
}

fn hold(rule: fn(&Source) -> Vec<String>) {
    let offences: Vec<_> = sources().iter().flat_map(rule).collect();
    assert!(offences.is_empty(), "\n{}", offences.join("\n"));
}

#[test]
fn modules_import_from_lower_layers_only() {
    hold(layer_offences);
}

#[test]
fn only_the_command_line_prints_or_exits() {
    hold(outward_offences);
}

#[test]
fn files_answer_one_question() {
    hold(size_offences);
}

#[test]
fn unsafe_code_is_listed_and_explained() {
    hold(unsafe_offences);
    for path in UNSAFE {
        let source = sources().into_iter().find(|s| s.path == path).unwrap();
        assert!(
            code(source.text.lines()).contains("unsafe"),
            "{path} needs no entry"
        );
    }
}

/// The Python package neither prints nor exits, has no unsafe code, and calls the library but not the command line.
#[test]
fn the_python_package_calls_the_library() {
    let rules = [outward_offences, size_offences, unsafe_offences];
    let sources = python_sources();
    let mut offences: Vec<_> = rules
        .iter()
        .flat_map(|rule| sources.iter().flat_map(rule))
        .collect();
    let calls_cli = |source: &&Source| code(source.lines()).contains("gearatlas::cli");
    offences.extend(sources.iter().filter(calls_cli).map(|s| s.path.clone()));
    assert!(offences.is_empty(), "\n{}", offences.join("\n"));
}

#[test]
fn files_of_a_module_import_one_way() {
    let circles = circles(&sources());
    assert!(circles.is_empty(), "\n{}", circles.join("\n"));
}

/// Every module declared in the root of a crate has a layer.
#[test]
fn every_module_has_a_layer() {
    let roots = sources().into_iter().filter(|s| s.path == "lib.rs");
    let modules: Vec<_> = roots
        .flat_map(|root| {
            let lines = root.text.lines().filter_map(|l| l.strip_prefix("pub mod "));
            lines.map(head).collect::<Vec<_>>()
        })
        .collect();
    assert!(modules.len() >= 19, "{modules:?}");
    for module in modules {
        assert!(layer(&module).is_some(), "{module} has no layer");
    }
}

mod planted {
    use super::*;

    fn source(path: &str, text: &str) -> Source {
        Source {
            path: path.to_owned(),
            text: text.to_owned(),
        }
    }

    #[test]
    fn upward_imports_are_found() {
        for text in [
            "use crate::analysis::Nvh;",
            "use crate::{numerics::legendre, analysis::{Nvh, Welch}};",
            "use crate::{\n    numerics::legendre,\n    analysis::Nvh,\n};",
            "fn f() { crate::analysis::investigate() }",
            "use crate::reference::Reference;",
            "#[cfg(test)]\nmod tests { use crate::store; }",
        ] {
            let found = layer_offences(&source("propagate/x.rs", text));
            assert_eq!(found.len(), 1, "{text}: {found:?}");
        }
        for text in [
            "use crate::{model::{Block, Contact}, numerics::legendre};",
            "//! See [`crate::analysis::Nvh`].",
            "use super::x; // crate::analysis",
            "use crate::propagate::events;",
            "use other_crate::analysis;",
        ] {
            let found = layer_offences(&source("propagate/x.rs", text));
            assert!(found.is_empty(), "{text}: {found:?}");
        }
        let found = layer_offences(&source("reference/x.rs", "use crate::numerics::legendre;"));
        assert_eq!(found, ["reference/x.rs imports numerics"]);
        let text = "#[cfg(test)]\nmod tests { use crate::structure::ModalStructure; }";
        assert!(layer_offences(&source("reference/x.rs", text)).is_empty());
        assert_eq!(layer_offences(&source("gadget/x.rs", "")).len(), 1);
    }

    #[test]
    fn printing_is_found_outside_the_command_line() {
        let text = "fn f() {\n    println!(\"x\");\n}\n";
        assert_eq!(outward_offences(&source("model/x.rs", text)).len(), 1);
        assert!(outward_offences(&source("cli/x.rs", text)).is_empty());
        let test = format!("#[cfg(test)]\nmod tests {{ {text} }}");
        assert!(outward_offences(&source("model/x.rs", &test)).is_empty());
    }

    #[test]
    fn long_files_are_found() {
        let text = "x\n".repeat(LONGEST + 1);
        assert_eq!(size_offences(&source("model/x.rs", &text)).len(), 1);
        let text = format!("{}#[cfg(test)]\n{text}", "x\n".repeat(LONGEST));
        assert!(size_offences(&source("model/x.rs", &text)).is_empty());
    }

    #[test]
    fn circles_are_found() {
        let found = |files: &[(&str, &str)]| {
            let files = files.iter().map(|(path, text)| source(path, text));
            circles(&files.collect::<Vec<_>>())
        };
        let circle = ["gear::a <-> gear::b", "gear::b <-> gear::a"];
        let first = ("gear/a.rs", "use super::b::B;");
        for text in [
            "use super::a::A;",
            "use crate::{model::M, gear::{x, a::{A, C}}};",
            "fn f() {}\n\npub(super) use super::a::A as Other;",
        ] {
            assert_eq!(found(&[first, ("gear/b.rs", text)]), circle, "{text}");
        }
        let handed_on = ("gear/mod.rs", "pub use a::A;");
        assert_eq!(
            found(&[first, ("gear/b.rs", "use super::A;"), handed_on]),
            circle
        );
        for text in [
            "// use super::a::A;",
            "#[cfg(test)]\nmod tests { use super::a::A; }",
            "use super::x::X;",
            "use crate::model::a::A;",
        ] {
            assert!(found(&[first, ("gear/b.rs", text)]).is_empty(), "{text}");
        }
        // A parent may re-export definitions of its children; they may not import its own imports through it.
        let child = ("gear/a/b.rs", "use super::A;");
        assert!(found(&[("gear/a.rs", "pub use b::B;"), child]).is_empty());
        assert_eq!(found(&[("gear/a.rs", "use b::B;"), child]).len(), 2);
    }

    #[test]
    fn unsafe_code_is_found() {
        let text = "// SAFETY: none.\nunsafe { f() }";
        assert_eq!(unsafe_offences(&source("model/x.rs", text)).len(), 1);
        assert!(unsafe_offences(&source(UNSAFE[0], text)).is_empty());
        assert_eq!(
            unsafe_offences(&source(UNSAFE[0], "unsafe { f() }")).len(),
            1
        );
        assert!(unsafe_offences(&source("model/x.rs", "#[allow(unsafe_code)]")).is_empty());
    }
}
