//! Files that are damaged, forged or foreign, byte by byte; a store through its calls.

use std::convert::Infallible;
use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use super::header::{Head, check_data, envelope, read_head};
use super::key::key;
use super::layout::{ALIGNMENT, CHECKSUM, PRELUDE};
use super::write::encode;
use super::*;

fn inputs() -> Value {
    json!({ "teeth": [25, 31], "module": 0.003 })
}

const INPUTS: &str = r#"{"module":0.003,"teeth":[25,31]}"#;

/// Bits that arithmetic would not keep, and lengths that leave gaps.
fn arrays() -> Arrays {
    let odd = vec![f64::NAN, -0.0, f64::MIN_POSITIVE / 4.0, f64::INFINITY, 0.1];
    let mut arrays = Arrays::new();
    arrays.push("odd", "1", &[5], odd).unwrap();
    let even = (0..18).map(f64::from).collect();
    arrays.push("stiffness", "N/m", &[2, 3, 3], even).unwrap();
    arrays.push("none", "m", &[0, 7], Vec::new()).unwrap();
    arrays.push("mean", "N/m", &[], vec![4e8]).unwrap();
    arrays
}

/// A table file.
fn file() -> Vec<u8> {
    let mut bytes = Vec::new();
    encode(&mut bytes, CacheKind::Mesh, INPUTS, &arrays()).unwrap();
    bytes
}

fn check(bytes: &[u8]) -> Result<Head, CacheFault> {
    let head = read_head(bytes, bytes.len())?;
    check_data(bytes, &head)?;
    Ok(head)
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// Asserts that a table has every bit of [`arrays`].
fn same(table: &MappedTable) {
    for array in arrays().iter() {
        let (shape, values) = table.array(&array.name).unwrap();
        assert_eq!(shape, array.shape);
        assert_eq!(bits(values), bits(&array.values), "{}", array.name);
        assert_eq!(table.unit(&array.name).unwrap(), array.unit);
        assert!(
            values.is_empty()
                || !table.has_file()
                || (values.as_ptr() as usize).is_multiple_of(ALIGNMENT)
        );
    }
    assert_eq!(table.names().count(), 4);
    assert_eq!(table.inputs(), INPUTS);
}

fn fetch(store: &TableStore) -> Fetched {
    let build = || Ok::<_, Infallible>(arrays());
    store
        .get_or_build(CacheKind::Mesh, &inputs(), build)
        .unwrap()
}

#[test]
fn a_table_is_built_once_and_has_every_bit_again() {
    let folder = tempfile::tempdir().unwrap();
    let store = TableStore::open(folder.path().join("deep/tables"));
    assert!(store.entries().unwrap().is_empty());
    let built = fetch(&store);
    assert_eq!(built.origin, Origin::Built);
    assert!(built.warnings.is_empty() && built.table.has_file());
    same(&built.table);
    let unwanted = || -> Result<Arrays, Infallible> { panic!("built twice") };
    let found = store
        .get_or_build(CacheKind::Mesh, &inputs(), unwanted)
        .unwrap();
    assert_eq!(found.origin, Origin::Found);
    same(&found.table);
    let error = found.table.array("shares").unwrap_err();
    assert!(
        error.to_string().contains("odd, stiffness, none, mean"),
        "{error}"
    );
    // Another kind or other inputs are another table.
    let other = json!({ "teeth": [25, 32], "module": 0.003 });
    for (kind, inputs) in [(CacheKind::Mesh, other), (CacheKind::Bases, inputs())] {
        let build = || Ok::<_, Infallible>(Arrays::new());
        assert_eq!(
            store.get_or_build(kind, &inputs, build).unwrap().origin,
            Origin::Built
        );
    }
    let entries = store.entries().unwrap();
    assert_eq!(entries.len(), 3);
    assert!(entries.iter().all(|entry| entry.header.is_ok()));
    assert_eq!(
        fs::read_dir(store.folder()).unwrap().count(),
        3,
        "a temporary file stayed"
    );
}

#[test]
fn an_error_of_the_builder_is_handed_on_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let store = TableStore::open(folder.path());
    let result = store.get_or_build(CacheKind::Mesh, &inputs(), || Err("no such flank"));
    assert_eq!(result.unwrap_err(), "no such flank");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn the_same_table_has_the_same_bytes() {
    assert_eq!(file(), file());
    assert_eq!(
        check(&file()).unwrap().header.key,
        key(CacheKind::Mesh, INPUTS)
    );
}

#[test]
fn any_flipped_bit_is_found() {
    let good = file();
    check(&good).unwrap();
    for at in 0..good.len() {
        for bit in 0..8 {
            let mut bad = good.clone();
            bad[at] ^= 1 << bit;
            assert!(check(&bad).is_err(), "byte {at}, bit {bit}");
        }
    }
}

#[test]
fn any_cut_and_any_tail_is_found() {
    let good = file();
    for length in 0..good.len() {
        let fault = check(&good[..length]).unwrap_err();
        match length {
            0 => assert!(matches!(fault, CacheFault::Empty)),
            _ => assert!(
                matches!(fault, CacheFault::CutOff { .. }),
                "{length}: {fault}"
            ),
        }
    }
    for tail in [1, 64, 4096] {
        let long = [&good[..], &vec![0; tail]].concat();
        let fault = check(&long).unwrap_err();
        assert!(
            matches!(fault, CacheFault::TooLong { .. }),
            "{tail}: {fault}"
        );
    }
}

/// Files with right checksums that say something wrong.
#[test]
fn foreign_files_are_told_apart() {
    let patched = |at: usize, bytes: &[u8]| {
        let mut file = file();
        file[at..at + bytes.len()].copy_from_slice(bytes);
        check(&file).unwrap_err().to_string()
    };
    let magic = patched(0, b"PAR1PAR1");
    assert_eq!(magic, "is not a table file of atlas");
    let order = patched(8, &0x0102_0304_u32.swap_bytes().to_ne_bytes());
    assert_eq!(order, "was written on a machine of the other byte order");
    let version = patched(12, &7_u32.to_ne_bytes());
    assert_eq!(
        version,
        "has format version 7; this program reads version 1"
    );
    for at in [16, 24] {
        for length in [u64::MAX, u64::MAX - 64, 1 << 62] {
            let fault = patched(at, &length.to_ne_bytes());
            let refused = fault.contains("damaged") || fault.contains("cut off");
            assert!(refused, "{at}: {fault}");
        }
    }
    assert_eq!(check(b"\x7fELF").unwrap_err().to_string(), magic);
    let text = check(b"atlas.svg").unwrap_err();
    assert!(matches!(text, CacheFault::Magic), "{text}");
}

/// What a header with a right checksum leads to: its text, with a piece replaced.
fn forged(from: &str, to: &str) -> CacheFault {
    let good = file();
    let head = check(&good).unwrap();
    let text = serde_json::to_string(&head.header).unwrap();
    assert!(text.contains(from), "{from} is not in {text}");
    let mut bytes = envelope(&text.replacen(from, to, 1), INPUTS);
    bytes.extend(&good[head.data..]);
    check(&bytes).unwrap_err()
}

#[test]
fn forged_headers_are_refused() {
    // Misaligned, overlapping, out of order, beyond the file, beyond what can be counted.
    for (from, to, words) in [
        (r#""offset":64,"#, r#""offset":65,"#, "multiple of 64"),
        (r#""offset":64,"#, r#""offset":0,"#, "behind the one before"),
        (
            r#""offset":64,"#,
            r#""offset":128,"#,
            "behind the one before",
        ),
        (
            r#""offset":64,"#,
            r#""offset":18446744073709551552,"#,
            "behind the one before",
        ),
        (r#""bytes":144"#, r#""bytes":152"#, "does not fit its shape"),
        ("[2,3,3]", "[2,3,4]", "does not fit its shape"),
        (
            "[2,3,3]",
            "[4294967296,4294967296,4294967296]",
            "does not fit its shape",
        ),
        ("[2,3,3]", "[-2,3,3]", "cannot be understood"),
        ("[2,3,3]", "[2.5,3,3]", "cannot be understood"),
        (r#""mean""#, r#""odd""#, "two of that name"),
        (
            r#""kind":"mesh""#,
            r#""kind":"bases""#,
            "not the hash of its inputs",
        ),
        (
            r#""kind":"mesh""#,
            r#""kind":"fused""#,
            "one for all speeds; `atlas table clean` removes the file",
        ),
        (
            r#""kind":"mesh""#,
            r#""kind":"noise""#,
            "cannot be understood",
        ),
        (r#""kind""#, r#""kinds""#, "cannot be understood"),
        ("{", "[", "cannot be understood"),
        (r#""data":""#, r#""data":"0"#, "damaged data"),
    ] {
        let fault = forged(from, to).to_string();
        assert!(fault.contains(words), "{from} → {to}: {fault}");
        assert!(!fault.contains('\n'), "{fault}");
    }
    // Each shape fits its length, and the whole asks for more than any machine has.
    let huge = r#""shape":[2000000000000,3,3],"offset":64,"bytes":144000000000000"#;
    let fault = forged(r#""shape":[2,3,3],"offset":64,"bytes":144"#, huge);
    assert!(matches!(fault, CacheFault::Layout { .. }), "{fault}");
    let last = r#""shape":[],"offset":256,"bytes":8"#;
    let huge = r#""shape":[2000000000000],"offset":256,"bytes":16000000000000"#;
    let fault = forged(last, huge);
    assert!(matches!(fault, CacheFault::CutOff { .. }), "{fault}");
    let fault = forged(
        last,
        r#""shape":[2305843009213693951],"offset":256,"bytes":18446744073709551608"#,
    );
    assert!(
        fault.to_string().contains("does not lie in the file"),
        "{fault}"
    );
}

#[test]
fn other_inputs_under_a_name_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let store = TableStore::open(folder.path());
    let path = store.path(CacheKind::Mesh, &inputs());
    let fault = |kind, inputs: &str| {
        let mut bytes = Vec::new();
        encode(&mut bytes, kind, inputs, &arrays()).unwrap();
        fs::write(&path, bytes).unwrap();
        refusal(&fetch(&store))
    };
    assert!(fault(CacheKind::Mesh, "{}").contains("was computed from other inputs"));
    let bases = fault(CacheKind::Bases, INPUTS);
    assert!(bases.contains("holds a bases table where a mesh table is wanted"));
    // A hash of other bytes, under a checksum that holds.
    let mut bytes = file();
    let at = PRELUDE + r#"{"kind":"mesh","key":""#.len();
    bytes[at] = if bytes[at] == b'0' { b'1' } else { b'0' };
    let end = read_head(&file(), file().len()).unwrap().data;
    let mut hash = blake3::Hasher::new();
    hash.update(&bytes[..CHECKSUM.start])
        .update(&bytes[CHECKSUM.end..end]);
    bytes[CHECKSUM].copy_from_slice(hash.finalize().as_bytes());
    assert!(matches!(check(&bytes), Err(CacheFault::Key)));
}

/// The one warning, of a file that was there and is refused.
fn refusal(fetched: &Fetched) -> String {
    let text = match &fetched.warnings[..] {
        [warning @ CacheWarning::Refused { .. }] => warning.to_string(),
        other => panic!("{other:?}"),
    };
    assert_eq!(fetched.origin, Origin::Built);
    assert!(!text.contains('\n'), "{text}");
    same(&fetched.table);
    text
}

#[test]
fn a_bad_file_is_named_and_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let store = TableStore::open(folder.path());
    let path = store.path(CacheKind::Mesh, &inputs());
    let good = file();
    for (bad, words) in [
        (Vec::new(), "is empty"),
        (good[..good.len() - 1].to_vec(), "is cut off"),
        ([&good[..], b"\n"].concat(), "where its header says"),
        (b"PAR1 or whatever".to_vec(), "is not a table file"),
    ] {
        replace(&path, &bad);
        let text = refusal(&fetch(&store));
        assert!(
            text.contains(words) && text.contains("computed anew"),
            "{text}"
        );
        assert!(text.contains(path.to_str().unwrap()), "{text}");
        assert_eq!(fs::read(&path).unwrap(), good);
        assert_eq!(fetch(&store).origin, Origin::Found);
    }
    let digits = path.file_name().unwrap().to_str().unwrap();
    assert_eq!(store.find(&digits[..9]).unwrap(), path);
}

/// As a program would that does not respect the mode of the file.
fn replace(path: &Path, bytes: &[u8]) {
    _ = fs::remove_file(path);
    fs::write(path, bytes).unwrap();
}

#[test]
fn clean_removes_what_it_is_told_to_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let store = TableStore::open(folder.path());
    let table = fetch(&store).table;
    let good = store.path(CacheKind::Mesh, &inputs());
    let bad = folder
        .path()
        .join(format!("spectral-{}.table", "0".repeat(32)));
    let later = folder
        .path()
        .join(format!("noise-{}.table", "1".repeat(32)));
    let mut bytes = file();
    bytes[12] = 9;
    let others = ["README.md", "notes.table", "mesh-12.table"].map(|n| folder.path().join(n));
    let prepare = || {
        replace(&bad, b"x");
        replace(&later, &bytes);
        others
            .iter()
            .for_each(|path| fs::write(path, "mine").unwrap());
        fs::write(
            folder.path().join(".mesh.x.partial"),
            "left by a killed process",
        )
        .unwrap();
    };
    prepare();
    assert_eq!(store.entries().unwrap().len(), 3);
    let cleaned = store.clean(Unwanted::Unusable).unwrap();
    assert_eq!(cleaned.files, [later.clone(), bad.clone()]);
    assert_eq!(cleaned.bytes, 1 + bytes.len() as u64);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4);
    let now = std::time::SystemTime::now();
    let day = std::time::Duration::from_secs(86_400);
    assert_eq!(
        store
            .clean(Unwanted::UnusedSince(now - day))
            .unwrap()
            .files
            .len(),
        0
    );
    let file = fs::File::open(&good).unwrap();
    file.set_modified(now - 3 * day).unwrap();
    // Reading it is use.
    assert_eq!(fetch(&store).origin, Origin::Found);
    assert_eq!(
        store
            .clean(Unwanted::UnusedSince(now - day))
            .unwrap()
            .files
            .len(),
        0
    );
    file.set_modified(now - 3 * day).unwrap();
    prepare();
    let cleaned = store.clean(Unwanted::UnusedSince(now - day)).unwrap();
    assert_eq!(cleaned.files, [good, later.clone(), bad.clone()]);
    // Who has it open keeps it.
    same(&table);
    prepare();
    fetch(&store);
    assert_eq!(store.clean(Unwanted::All).unwrap().files.len(), 3);
    assert!(others.iter().all(|path| path.exists()));
}

#[test]
fn keys_are_found_by_their_first_digits() {
    let folder = tempfile::tempdir().unwrap();
    let store = TableStore::open(folder.path());
    for digit in ["00", "01"] {
        let name = format!("mesh-{digit}{}.table", "a".repeat(30));
        fs::write(folder.path().join(name), "").unwrap();
    }
    let name = |wanted: &str| {
        store
            .find(wanted)
            .map(|path| path.file_name().unwrap().to_owned())
    };
    assert!(name("00").unwrap().to_str().unwrap().starts_with("mesh-00"));
    assert!(
        name("mesh-01")
            .unwrap()
            .to_str()
            .unwrap()
            .starts_with("mesh-01")
    );
    assert!(matches!(name("0"), Err(CacheError::Ambiguous { found, .. }) if found.len() == 2));
    for nothing in ["", "1", "spectral", "../"] {
        assert!(
            matches!(name(nothing), Err(CacheError::Unknown { .. })),
            "{nothing}"
        );
    }
}
