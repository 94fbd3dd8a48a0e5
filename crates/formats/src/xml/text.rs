//! Files as text, however they are written.

use super::{Note, Tree, parse};
use crate::error::{FormatError, Location};

/// The marks with which UTF-16 begins.
const LITTLE_ENDIAN: [u8; 2] = [0xff, 0xfe];
const BIG_ENDIAN: [u8; 2] = [0xfe, 0xff];

/// A file as text.
pub(crate) struct Text {
    pub text: String,
    /// The first line in which bytes are not UTF-8.
    foreign: Option<u32>,
}

impl Text {
    /// UTF-8, or UTF-16 with its mark. Where bytes are neither, as in files of editors that write in a country's own way, each is a character (ISO 8859-1):
    /// mostly they are in comments and names, and what is the same stays so.
    ///
    /// # Errors
    /// What it is where it is no text.
    pub fn of(bytes: Vec<u8>) -> Result<Self, String> {
        let utf16 = |unit: fn([u8; 2]) -> u16| {
            let units: Vec<u16> = bytes.as_chunks().0.iter().map(|pair| unit(*pair)).collect();
            String::from_utf16(&units).map_err(|_| "neither UTF-8 nor UTF-16 text".to_owned())
        };
        if bytes.starts_with(&LITTLE_ENDIAN) || bytes.starts_with(&BIG_ENDIAN) {
            let text = utf16(if bytes.starts_with(&BIG_ENDIAN) { u16::from_be_bytes } else { u16::from_le_bytes })?;
            return Ok(Self { text, foreign: None });
        }
        if bytes.contains(&0) {
            return Err("not text: MJCF, URDF and SDF are XML".to_owned());
        }
        match String::from_utf8(bytes) {
            Ok(text) => Ok(Self { text, foreign: None }),
            Err(error) => {
                let valid = error.utf8_error().valid_up_to();
                let bytes = error.into_bytes();
                let line = 1 + bytes[..valid].iter().filter(|byte| **byte == b'\n').count() as u32;
                Ok(Self { text: bytes.into_iter().map(char::from).collect(), foreign: Some(line) })
            }
        }
    }

    /// Its elements, with a note where it is not UTF-8.
    ///
    /// # Errors
    /// As [`parse`].
    pub fn parse(&self, file: &str) -> Result<Tree, FormatError> {
        let tree = parse(&self.text, file)?;
        if let Some(line) = self.foreign {
            let at = Location { file: file.into(), line, column: 1 };
            let effect =
                "it is read as ISO 8859-1: names with letters beyond ASCII may look otherwise; save the file as UTF-8";
            tree.note(Note::other(at, tree.root().name(), "is not UTF-8 text", effect));
        }
        Ok(tree)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const XML: &str = "<robot>\n<!-- Größe -->\n<link name=\"Füße\"/></robot>";

    #[test]
    fn the_same_text_is_read_in_three_ways_of_writing() {
        let latin: Vec<u8> = XML.chars().map(|c| u8::try_from(c).unwrap()).collect();
        let units = || std::iter::once(0xfeff).chain(XML.encode_utf16());
        let little = units().flat_map(u16::to_le_bytes).collect();
        let big = units().flat_map(u16::to_be_bytes).collect();
        for (bytes, foreign) in [(XML.as_bytes().to_vec(), None), (latin, Some(2)), (little, None), (big, None)] {
            let text = Text::of(bytes).unwrap();
            assert_eq!((text.text.trim_start_matches('\u{feff}'), text.foreign), (XML, foreign));
            let tree = text.parse("a.urdf").unwrap();
            assert_eq!(tree.root().child("link").unwrap().attributes().text("name"), Some("Füße"));
            let notes = tree.take_notes();
            assert_eq!(notes.first().map(|note| note.at.line), foreign);
        }
    }

    #[test]
    fn what_is_no_text_is_called_that() {
        assert!(Text::of(vec![0x89, b'P', 0, 1]).err().unwrap().contains("not text"));
        // Half of a pair of surrogates.
        assert!(Text::of(vec![0xff, 0xfe, 0x00, 0xd8]).err().unwrap().contains("UTF-16"));
    }
}
