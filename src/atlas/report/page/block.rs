//! Arrays as text in a page: little-endian bytes, one byte plane after the other, deflated, in base64.
//!
//! Neighbouring values of a column mostly have equal leading bytes. Therefore byte planes compress better
//! than a sequence of whole values. Browsers can inflate the zlib format without a library.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;

/// The arrays of a page, by their numbers.
#[derive(Debug, Default)]
pub(super) struct Blocks {
    texts: Vec<String>,
    /// Whether the first picture of the page needs the array.
    is_first: Vec<bool>,
    bytes: u64,
}

impl Blocks {
    /// Adds an array, the output of [`packed`]; returns its number.
    pub fn push(&mut self, packed: String) -> usize {
        self.bytes += packed.len() as u64;
        self.texts.push(packed);
        self.is_first.push(false);
        self.texts.len() - 1
    }

    /// Marks the arrays from a number on as needed by the first picture.
    pub fn mark_for_first_picture(&mut self, from: usize) {
        self.is_first[from..].fill(true);
    }

    /// Number of characters of all arrays.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Number of arrays.
    pub fn count(&self) -> usize {
        self.texts.len()
    }

    /// Appends the arrays that the first picture needs (`first`), or all others, as elements of the page, in
    /// the order of their numbers. Consumes their texts.
    pub fn write(&mut self, first: bool, html: &mut String) {
        let all = self.texts.iter_mut().zip(&self.is_first).enumerate();
        for (number, (text, _)) in all.filter(|(_, (_, is_first))| **is_first == first) {
            *html += &format!("<script type=\"text/plain\" id=\"block-{number}\">");
            *html += &std::mem::take(text);
            *html += "</script>\n";
        }
    }
}

/// Packs numbers; a missing number is NaN.
pub(super) fn numbers(values: &[f64]) -> String {
    packed(&planes(values.iter().map(|value| value.to_le_bytes())))
}

/// Packs whole numbers below 2³².
pub(super) fn codes(values: &[u32]) -> String {
    packed(&planes(values.iter().map(|value| value.to_le_bytes())))
}

/// Packs texts, as a JSON list.
pub(super) fn texts(values: &[String]) -> String {
    packed(serde_json::json!(values).to_string().as_bytes())
}

/// The first bytes of all elements, then their second bytes, and so on.
fn planes<const N: usize>(elements: impl ExactSizeIterator<Item = [u8; N]>) -> Vec<u8> {
    let rows = elements.len();
    let mut bytes = vec![0; N * rows];
    for (row, element) in elements.enumerate() {
        for (plane, byte) in element.into_iter().enumerate() {
            bytes[plane * rows + row] = byte;
        }
    }
    bytes
}

/// Deflates bytes, with the header and the checksum of zlib, and encodes them in base64.
fn packed(bytes: &[u8]) -> String {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    // Writing to a vector cannot fail.
    let deflated = encoder.write_all(bytes).and_then(|()| encoder.finish());
    STANDARD.encode(deflated.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    #[test]
    fn blocks_decode_back_to_the_values() {
        let values: Vec<f64> = (0..1000).map(|i| (f64::from(i) * 0.37).sin()).collect();
        let bytes = STANDARD.decode(numbers(&values)).unwrap();
        let mut planes = Vec::new();
        flate2::read::ZlibDecoder::new(&bytes[..])
            .read_to_end(&mut planes)
            .unwrap();
        let value =
            |row: usize| f64::from_le_bytes(std::array::from_fn(|p| planes[p * 1000 + row]));
        let back: Vec<f64> = (0..1000).map(value).collect();
        assert_eq!(back, values);
    }

    #[test]
    fn columns_of_one_value_take_next_to_nothing() {
        assert!(numbers(&vec![f64::NAN; 100_000]).len() < 2000);
        let ids: Vec<f64> = (0..100_000).map(f64::from).collect();
        assert!(numbers(&ids).len() < 400_000, "half of 800 000 bytes");
    }
}
