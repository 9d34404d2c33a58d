//! In which folder are the resources? FMI 2.0 gives it as a URI.

use std::ffi::OsString;
use std::os::unix::ffi::OsStringExt;
use std::path::PathBuf;

/// The folder of a URI such as `file:///a%20b`. It also accepts `file:/a b` and a plain path, which some
/// importers give.
pub fn of_uri(uri: &str) -> PathBuf {
    let plain = uri.strip_prefix("file:").map(|rest| {
        let rest = rest.strip_prefix("//").unwrap_or(rest);
        rest.strip_prefix("localhost").unwrap_or(rest)
    });
    let Some(rest) = plain else {
        return PathBuf::from(uri);
    };
    let digit = |byte: Option<&u8>| byte.and_then(|byte| char::from(*byte).to_digit(16));
    let (bytes, mut out, mut at) = (rest.as_bytes(), Vec::new(), 0);
    while let Some(&byte) = bytes.get(at) {
        match (byte, digit(bytes.get(at + 1)), digit(bytes.get(at + 2))) {
            (b'%', Some(high), Some(low)) => {
                out.push((16 * high + low) as u8);
                at += 3;
            }
            _ => {
                out.push(byte);
                at += 1;
            }
        }
    }
    PathBuf::from(OsString::from_vec(out))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_taken_out_of_uris() {
        for (uri, path) in [
            ("file:///tmp/a%20b%C3%A9/resources", "/tmp/a bé/resources"),
            ("file://localhost/tmp/x", "/tmp/x"),
            ("file:/tmp/a b", "/tmp/a b"),
            ("file:///100%/%zz", "/100%/%zz"),
            ("/tmp/100%25", "/tmp/100%25"),
        ] {
            assert_eq!(of_uri(uri), PathBuf::from(path), "{uri}");
        }
    }
}
