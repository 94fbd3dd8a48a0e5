//! Damaged documents: whatever is done to a model file, the answer is a model or a placed error, never a panic. The fuzz
//! targets look for more.

use signorini_formats::{FormatError, Imported, LoadOptions, load_mjcf_str, load_sdf_str, load_urdf_str};

type Read = fn(&str) -> Result<Imported, FormatError>;

fn mjcf(text: &str) -> Result<Imported, FormatError> {
    load_mjcf_str(text, "no such folder")
}

fn urdf(text: &str) -> Result<Imported, FormatError> {
    load_urdf_str(text, "no such folder", &LoadOptions::default())
}

fn sdf(text: &str) -> Result<Imported, FormatError> {
    load_sdf_str(text, "no such folder", &LoadOptions::default())
}

const DOCUMENTS: [(&str, Read); 11] = [
    (include_str!("../../testdata/mjcf/defaults.xml"), mjcf),
    (include_str!("../../testdata/mjcf/poses.xml"), mjcf),
    (include_str!("../../testdata/mjcf/fromto.xml"), mjcf),
    (include_str!("../../testdata/mjcf/inertia.xml"), mjcf),
    (include_str!("../../testdata/mjcf/joints.xml"), mjcf),
    (include_str!("../../testdata/mjcf/contacts.xml"), mjcf),
    (include_str!("../../testdata/mjcf/meshes.xml"), mjcf),
    (include_str!("../../testdata/urdf/arm.urdf"), urdf),
    (include_str!("../../testdata/urdf/floating.urdf"), urdf),
    (include_str!("../../testdata/mjcf/instruments.xml"), mjcf),
    (include_str!("../../testdata/sdf/arm.sdf"), sdf),
];

/// Values that parsers and formulas stumble over.
const HOSTILE: [&str; 14] = [
    "",
    " ",
    "0",
    "-1",
    "1e308",
    "-1e308",
    "1e-320",
    "nan",
    "inf",
    "9223372036854775808",
    "1 2 3 4 5 6 7 8",
    "world",
    "true",
    "\u{fffd}é",
];

/// A small generator (Marsaglia's xorshift), so that failures repeat.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % n.max(1) as u64) as usize
    }
}

fn assert_survives(read: Read, text: &str) {
    if let Err(error) = read(text) {
        let message = error.to_string();
        assert!(message.contains(" text):"), "no place in '{message}' for {text}");
    }
}

#[test]
fn every_attribute_of_every_document_takes_every_hostile_value() {
    for (text, read) in DOCUMENTS {
        let marks: Vec<usize> = text.match_indices(['"', '\'']).map(|(i, _)| i).collect();
        for ends in marks.chunks_exact(2) {
            for value in HOSTILE {
                assert_survives(read, &format!("{}{value}{}", &text[..=ends[0]], &text[ends[1]..]));
            }
        }
    }
}

/// SDF's values are texts of elements.
#[test]
fn every_text_of_sdf_takes_every_hostile_value() {
    let (text, read) = DOCUMENTS[DOCUMENTS.len() - 1];
    let ends = text.match_indices("</").map(|(i, _)| i);
    for end in ends {
        let Some(start) = text[..end].rfind('>') else { continue };
        for value in HOSTILE {
            assert_survives(read, &format!("{}{value}{}", &text[..=start], &text[end..]));
        }
    }
}

#[test]
fn documents_survive_cuts_and_swaps() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for (text, read) in DOCUMENTS {
        let lines: Vec<&str> = text.lines().collect();
        for _ in 0..300 {
            let mut changed = lines.clone();
            for _ in 0..=random.below(3) {
                let (a, b) = (random.below(changed.len()), random.below(changed.len()));
                match random.below(3) {
                    0 => changed.swap(a, b),
                    1 => changed.insert(a, lines[random.below(lines.len())]),
                    _ => drop(changed.remove(a)),
                }
            }
            assert_survives(read, &changed.join("\n"));
        }
        for _ in 0..100 {
            let cut = random.below(text.len());
            assert_survives(read, &String::from_utf8_lossy(&text.as_bytes()[..cut]));
        }
    }
}

#[test]
fn deep_and_wide_documents_are_answered() {
    let chain = |n: usize| {
        let open = "<body><joint axis='0 1 0'/><geom size='.1'/>".repeat(n);
        format!("<mujoco><worldbody>{open}{}</worldbody></mujoco>", "</body>".repeat(n))
    };
    assert_eq!(mjcf(&chain(1000)).unwrap().model.nv, 1000);
    assert!(mjcf(&chain(5000)).unwrap_err().to_string().contains("nested more than"));
    let copies = "<replicate count='100000'>".repeat(3);
    let bomb = format!("<mujoco><worldbody>{copies}<geom size='1'/>{}</worldbody></mujoco>", "</replicate>".repeat(3));
    assert!(mjcf(&bomb).unwrap_err().to_string().contains("more than"));
    let models = |n: usize| {
        let open: String = (0..n).map(|k| format!("<model name='m{k}'>")).collect();
        format!("<sdf version='1.9'>{open}<link name='l'/>{}</sdf>", "</model>".repeat(n))
    };
    assert_eq!(sdf(&models(100)).unwrap().model.nv, 6);
    assert!(sdf(&models(1000)).unwrap_err().to_string().contains("nested more than"));
    let entities = "<!DOCTYPE m [<!ENTITY a 'aaaaaaaaaa'>]><mujoco model='&a;'/>";
    assert_eq!(mjcf(entities).unwrap().model.name, "&a;", "entities of a DTD are not expanded");
}
