//! The data of an FMU that change during a simulation, and their form in bytes.
//!
//! ```text
//!   0  "atlasfmu"
//!   8  version  u32, little-endian
//!  12  total length in bytes  u32
//!  16  words of 8 bytes, in the order of `LiveState::bytes`
//! ```

use super::inputs::INPUTS;
use crate::model::ActiveSet;
use crate::propagate::varying_speed::Motion;

const MAGIC: &[u8; 8] = b"atlasfmu";
/// Version of the format. It changes whenever the format does.
const VERSION: u32 = 1;

/// Stage of an FMU, from its creation to its termination.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Created, but not initialised.
    Instantiated,
    /// Between the calls that enter and exit the initialization mode.
    Initialization,
    /// Ready to be stepped.
    Step,
    /// Ended.
    Terminated,
}

impl Mode {
    const ALL: [Self; 4] = [
        Self::Instantiated,
        Self::Initialization,
        Self::Step,
        Self::Terminated,
    ];

    /// Name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Instantiated => "before initialization",
            Self::Initialization => "in initialization mode",
            Self::Step => "in step mode",
            Self::Terminated => "after termination",
        }
    }
}

/// The data of an FMU that change during a simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct LiveState {
    /// Stage of the FMU.
    pub mode: Mode,
    /// Values of the parameters.
    pub parameters: Vec<f64>,
    /// Values of the inputs.
    pub inputs: [f64; INPUTS],
    /// Rates of change of the inputs, per second.
    pub rates: [f64; INPUTS],
    /// Time \[s\].
    pub time: f64,
    /// Mean speed of the pinion \[rad/s\].
    pub speed: f64,
    /// Number of openings and closings of contacts.
    pub events: u64,
    /// The motion; `None` until it begins.
    pub motion: Option<Motion>,
}

/// Copies a motion, without allocation if both belong to one drive.
pub fn copy(to: &mut Motion, from: &Motion) {
    let mut state = std::mem::take(&mut to.state);
    state.clone_from(&from.state);
    *to = Motion { state, ..*from };
}

/// Reads words of 8 bytes from the front of a slice.
struct Reader<'b>(&'b [u8]);

impl Reader<'_> {
    fn word(&mut self) -> Option<u64> {
        let (word, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(u64::from_le_bytes(*word))
    }

    fn number(&mut self) -> Option<f64> {
        self.word().map(f64::from_bits)
    }

    fn numbers<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut out = [0.0; N];
        for value in &mut out {
            *value = self.number()?;
        }
        Some(out)
    }

    fn list(&mut self) -> Option<Vec<f64>> {
        let length = usize::try_from(self.word()?).ok()?;
        // Check the length before the allocation: faulty bytes may announce more numbers than they contain.
        (length <= self.0.len() / 8).then_some(())?;
        (0..length).map(|_| self.number()).collect()
    }

    fn set(&mut self) -> Option<ActiveSet> {
        Some(ActiveSet::of_words([self.word()?, self.word()?]))
    }
}

impl LiveState {
    /// Copies another state, without allocation if both belong to one drive and have a motion.
    pub fn copy(&mut self, from: &Self) {
        self.parameters.clone_from(&from.parameters);
        match (&mut self.motion, &from.motion) {
            (Some(target), Some(motion)) => copy(target, motion),
            (target, motion) => target.clone_from(motion),
        }
        (self.mode, self.inputs, self.rates) = (from.mode, from.inputs, from.rates);
        (self.time, self.speed, self.events) = (from.time, from.speed, from.events);
    }

    /// The bytes of the state.
    pub fn bytes(&self) -> Vec<u8> {
        let mut words = Vec::new();
        let mut list = |numbers: &[f64]| {
            words.push(numbers.len() as u64);
            words.extend(numbers.iter().map(|number| number.to_bits()));
        };
        list(&self.parameters);
        let state = self.motion.as_ref().map(|motion| &motion.state[..]);
        list(state.unwrap_or_default());
        words.push(self.mode as u64);
        let numbers = self.inputs.iter().chain(&self.rates);
        words.extend(
            numbers
                .chain([&self.time, &self.speed])
                .map(|number| number.to_bits()),
        );
        words.push(self.events);
        if let Some(motion) = &self.motion {
            let [standing, opening] = motion.standing;
            let sets = [motion.contact, standing, opening].map(ActiveSet::words);
            words.extend(sets.as_flattened());
            words.push(motion.cycle);
            words.extend([motion.phase, motion.time].map(f64::to_bits));
            words.push(u64::from(motion.events));
        }
        let length = (16 + 8 * words.len()) as u32;
        let head = [&MAGIC[..], &VERSION.to_le_bytes(), &length.to_le_bytes()].concat();
        let words = words.iter().flat_map(|word| word.to_le_bytes());
        head.into_iter().chain(words).collect()
    }

    /// Reads a state from its bytes.
    ///
    /// # Errors
    /// A sentence if the bytes are not a state of this version.
    pub fn of_bytes(bytes: &[u8]) -> Result<Self, String> {
        let rest = bytes
            .strip_prefix(MAGIC)
            .ok_or("these bytes are no state of an FMU of atlas")?;
        let head = rest.split_first_chunk::<8>();
        let (head, rest) = head.ok_or("the state is cut off")?;
        let [version, length] = [0, 4]
            .map(|at| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]));
        if version != VERSION {
            return Err(format!(
                "the state has format version {version}; this library reads version {VERSION}"
            ));
        }
        if length as usize != bytes.len() {
            return Err(format!(
                "the state has {} bytes, but says {length}",
                bytes.len()
            ));
        }
        let mut reader = Reader(rest);
        let live = read(&mut reader).filter(|_| reader.0.is_empty());
        live.ok_or_else(|| "the state is damaged".to_owned())
    }
}

fn read(reader: &mut Reader<'_>) -> Option<LiveState> {
    let [parameters, state] = [reader.list()?, reader.list()?];
    let mode = usize::try_from(reader.word()?).ok()?;
    let mut live = LiveState {
        mode: *Mode::ALL.get(mode)?,
        parameters,
        inputs: reader.numbers()?,
        rates: reader.numbers()?,
        time: reader.number()?,
        speed: reader.number()?,
        events: reader.word()?,
        motion: None,
    };
    if !state.is_empty() {
        let [contact, standing, opening] = [reader.set()?, reader.set()?, reader.set()?];
        live.motion = Some(Motion {
            state,
            contact,
            standing: [standing, opening],
            cycle: reader.word()?,
            phase: reader.number()?,
            time: reader.number()?,
            events: u32::try_from(reader.word()?).ok()?,
        });
    }
    Some(live)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn live() -> LiveState {
        LiveState {
            mode: Mode::Step,
            parameters: vec![0.1, -0.0],
            inputs: [1.0, 2.0, 3.0],
            rates: [0.5, f64::MIN_POSITIVE, 0.0],
            time: 0.25,
            speed: 700.0,
            events: 12,
            motion: Some(Motion {
                state: vec![1.5, 1e-300, -2.0, 7.0],
                contact: ActiveSet::DRIVE,
                cycle: 3,
                phase: 0.125,
                time: 0.3,
                standing: [ActiveSet::COAST, ActiveSet::FREE.toggled(100)],
                events: 4,
            }),
        }
    }

    #[test]
    fn a_state_is_its_bytes() {
        for own in [
            live(),
            LiveState {
                motion: None,
                ..live()
            },
        ] {
            let bytes = own.bytes();
            assert_eq!(LiveState::of_bytes(&bytes).unwrap(), own);
            for end in 0..bytes.len() {
                assert!(LiveState::of_bytes(&bytes[..end]).is_err(), "{end}");
            }
            assert!(LiveState::of_bytes(&[&bytes[..], &[0]].concat()).is_err());
        }
        let mut other = live().bytes();
        other[8] = 2;
        assert!(
            LiveState::of_bytes(&other)
                .unwrap_err()
                .contains("version 2")
        );
        // The announced number of parameters exceeds the bytes.
        let mut longer = live().bytes();
        longer[16..24].copy_from_slice(&u64::MAX.to_le_bytes());
        assert_eq!(
            LiveState::of_bytes(&longer).unwrap_err(),
            "the state is damaged"
        );
    }

    #[test]
    fn a_state_is_taken_over_whole() {
        let mut other = LiveState {
            parameters: vec![9.0],
            motion: None,
            ..live()
        };
        other.copy(&live());
        assert_eq!(other, live());
        other.copy(&LiveState {
            motion: None,
            ..live()
        });
        assert_eq!(other.motion, None);
    }
}
