//! Inputs from seeds by a seeded generator: flips, cuts, copies, splices, words of a dictionary, and extreme numbers
//! instead of numbers.

use super::dice::Dice;

/// Largest size of an input \[bytes\].
const LONGEST: usize = 32 << 10;

/// Seeds and words for inputs.
pub struct Mutations {
    pub seeds: Vec<Vec<u8>>,
    pub words: Vec<String>,
}

impl Mutations {
    /// An input.
    pub fn draw(&self, dice: &mut Dice) -> Vec<u8> {
        let mut bytes = self.seeds[dice.below(self.seeds.len())].clone();
        // Few changes find most faults; many changes reach unchecked parts of the input.
        let changes = 1 << dice.below(6);
        for _ in 0..changes {
            self.change(&mut bytes, dice);
        }
        bytes.truncate(LONGEST);
        bytes
    }

    fn change(&self, bytes: &mut Vec<u8>, dice: &mut Dice) {
        let at = dice.below(bytes.len() + 1);
        let end = (at + 1 + dice.below(16)).min(bytes.len());
        match dice.below(11) {
            0 if at < bytes.len() => bytes[at] ^= 1 << dice.below(8),
            1 if at < bytes.len() => bytes[at] = dice.below(256) as u8,
            2 => bytes.insert(at, dice.below(256) as u8),
            3 if at < end => _ = bytes.drain(at..end),
            4 => {
                let piece = bytes[at..end].to_vec();
                bytes.splice(at..at, piece.repeat(1 + dice.below(4)));
            }
            5 => bytes.truncate(at),
            6 => {
                let other = &self.seeds[dice.below(self.seeds.len())];
                let from = dice.below(other.len() + 1);
                let to = (from + dice.below(200)).min(other.len());
                bytes.splice(at..at, other[from..to].iter().copied());
            }
            7 | 8 => {
                let word = self.words[dice.below(self.words.len())].bytes();
                if dice.chance(0.5) {
                    _ = bytes.splice(at..at, word)
                } else {
                    _ = bytes.splice(word_at(bytes, at), word)
                }
            }
            _ => lines(bytes, dice),
        }
    }
}

/// The word around a position.
fn word_at(bytes: &[u8], at: usize) -> std::ops::Range<usize> {
    let inside = |byte: &&u8| byte.is_ascii_alphanumeric() || b"_.-+".contains(*byte);
    let before = bytes[..at].iter().rev().take_while(inside).count();
    let behind = bytes[at..].iter().take_while(inside).count();
    at - before..at + behind
}

/// Removes a line, repeats it elsewhere, or swaps two lines.
fn lines(bytes: &mut Vec<u8>, dice: &mut Dice) {
    let mut all: Vec<Vec<u8>> = (bytes.split(|byte| *byte == b'\n'))
        .map(<[u8]>::to_vec)
        .collect();
    let [one, two] = [(); 2].map(|()| dice.below(all.len()));
    match dice.below(3) {
        0 => _ = all.remove(one),
        1 => all.insert(two, all[one].clone()),
        _ => all.swap(one, two),
    }
    *bytes = all.join(&b'\n');
}
