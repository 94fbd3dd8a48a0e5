//! An MP4 file with one track of H.264 (ISO/IEC 14496-12 and -15), what players need of it.

/// One coded frame, its units after their lengths.
pub(crate) struct Sample {
    pub data: Vec<u8>,
    /// Whether it stands alone.
    pub key: bool,
}

/// A film in one track.
pub(crate) struct Track<'a> {
    pub size: [usize; 2],
    /// Frames per second.
    pub rate: f64,
    /// Sequence and picture parameter set.
    pub sequence: &'a [u8],
    pub picture: &'a [u8],
    pub samples: &'a [Sample],
}

/// Ticks of the clock in a second: rates of films are whole parts of it.
const CLOCK: f64 = 90_000.0;
/// The matrix that leaves a picture as it is, in fixed point.
const UNTURNED: [u32; 9] = [0x1_0000, 0, 0, 0, 0x1_0000, 0, 0, 0, 0x4000_0000];

/// A box: its length, its kind, its content.
fn boxed(kind: &[u8; 4], content: &[&[u8]]) -> Vec<u8> {
    let length = 8 + content.iter().map(|part| part.len()).sum::<usize>();
    let mut bytes = Vec::with_capacity(length);
    bytes.extend((length as u32).to_be_bytes());
    bytes.extend(kind);
    content.iter().for_each(|part| bytes.extend(*part));
    bytes
}

/// Numbers of 32 bits.
fn words(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_be_bytes()).collect()
}

impl Track<'_> {
    /// The whole file: what is in it first, so that it plays while it is being fetched.
    pub fn file(&self) -> Vec<u8> {
        let kind = boxed(b"ftyp", &[b"isom", &words(&[512]), b"isomiso2avc1mp41"]);
        // The places of the frames depend on the length of what comes before them, which does not depend on the places.
        let before = kind.len() + self.movie(0).len() + 8;
        let movie = self.movie(before as u32);
        let frames: Vec<&[u8]> = self.samples.iter().map(|sample| &sample.data[..]).collect();
        [kind, movie, boxed(b"mdat", &frames)].concat()
    }

    fn tick(&self) -> u32 {
        (CLOCK / self.rate).round().max(1.0) as u32
    }

    fn movie(&self, first: u32) -> Vec<u8> {
        let duration = self.tick().saturating_mul(self.samples.len() as u32);
        let head =
            [&[0, 0, 0, CLOCK as u32, duration, 0x1_0000, 0x0100_0000, 0, 0][..], &UNTURNED, &[0; 6], &[2]].concat();
        let [width, height] = self.size.map(|n| n as u32);
        let track = [&[3, 0, 0, 1, 0, duration, 0, 0, 0, 0][..], &UNTURNED, &[width << 16, height << 16]].concat();
        let media = words(&[0, 0, 0, CLOCK as u32, duration, 0x55c4_0000]);
        let handler = [&words(&[0, 0])[..], b"vide", &words(&[0, 0, 0]), b"film\0"].concat();
        let reference = boxed(b"dref", &[&words(&[0, 1]), &boxed(b"url ", &[&words(&[1])])]);
        let information = boxed(
            b"minf",
            &[&boxed(b"vmhd", &[&words(&[1, 0, 0])]), &boxed(b"dinf", &[&reference]), &self.table(first)],
        );
        let media = boxed(b"mdia", &[&boxed(b"mdhd", &[&media]), &boxed(b"hdlr", &[&handler]), &information]);
        let track = boxed(b"trak", &[&boxed(b"tkhd", &[&words(&track)]), &media]);
        boxed(b"moov", &[&boxed(b"mvhd", &[&words(&head)]), &track])
    }

    /// Where the frames are, how long they are, and when they are shown.
    fn table(&self, first: u32) -> Vec<u8> {
        let count = self.samples.len() as u32;
        let sizes = self.samples.iter().map(|sample| sample.data.len() as u32);
        let keys = self.samples.iter().enumerate().filter(|(_, sample)| sample.key).map(|(i, _)| i as u32 + 1);
        let keys: Vec<u32> = keys.collect();
        boxed(
            b"stbl",
            &[
                &boxed(b"stsd", &[&words(&[0, 1]), &self.description()]),
                &boxed(b"stts", &[&words(&[0, 1, count, self.tick()])]),
                &boxed(b"stss", &[&words(&[0, keys.len() as u32]), &words(&keys)]),
                &boxed(b"stsc", &[&words(&[0, 1, 1, count, 1])]),
                &boxed(b"stsz", &[&words(&[0, 0, count]), &words(&sizes.collect::<Vec<_>>())]),
                &boxed(b"stco", &[&words(&[0, 1, first])]),
            ],
        )
    }

    fn description(&self) -> Vec<u8> {
        let [width, height] = self.size.map(|n| (n as u16).to_be_bytes());
        // 72 dots per inch, one frame per sample, 24 bits.
        let look =
            [&words(&[0, 1, 0, 0, 0, 0])[..], &width, &height, &words(&[0x48_0000, 0x48_0000, 0]), &[0, 1]].concat();
        let look = [&look[..], &[0; 32], &[0, 24, 0xff, 0xff]].concat();
        let set = |set: &[u8]| [&(set.len() as u16).to_be_bytes(), set].concat();
        // Profile and level stand behind the first byte of the sequence parameters; lengths of units have four bytes.
        let [profile, constraints, level] = [self.sequence[1], self.sequence[2], self.sequence[3]];
        let head = [1, profile, constraints, level, 0xff, 0xe1];
        let codec = boxed(b"avcC", &[&head, &set(self.sequence), &[1], &set(self.picture)]);
        // Primaries and transfer of BT.709, which are those of sRGB, and the matrix of BT.601.
        let color = boxed(b"colr", &[b"nclx", &[0, 1, 0, 1, 0, 6, 0]]);
        boxed(b"avc1", &[&look, &codec, &color])
    }
}
