//! The part of the zip format that `.npz` files use: stored and deflated members, no encryption,
//! no archive beyond 4 GiB.
//!
//! # Source
//! PKWARE, APPNOTE.TXT (.ZIP File Format Specification), §4.3.

use crate::error::MemberProblem;

const LOCAL_HEADER: u32 = 0x0403_4b50;
const DIRECTORY_ENTRY: u32 = 0x0201_4b50;
const DIRECTORY_END: u32 = 0x0605_4b50;
const LOCAL_HEADER_SIZE: usize = 30;
const DIRECTORY_ENTRY_SIZE: usize = 46;
const DIRECTORY_END_SIZE: usize = 22;
/// The end record is followed by a comment of at most this many bytes.
const LONGEST_COMMENT: usize = 0xFFFF;
const STORED: u16 = 0;
const DEFLATED: u16 = 8;
/// 1980-01-01, so that equal contents give equal files.
const NO_DATE: u16 = 0x0021;

/// Where one member lies, from the archive's directory.
#[derive(Debug, Clone)]
pub(crate) struct Member {
    flags: u16,
    method: u16,
    crc: u32,
    packed: usize,
    unpacked: usize,
    header: usize,
}

/// A fault of the archive as a whole.
pub(crate) struct Fault {
    pub offset: usize,
    pub problem: &'static str,
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    let field = bytes.get(at..at.checked_add(2)?)?;
    Some(u16::from_le_bytes([field[0], field[1]]))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    let field = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_le_bytes([field[0], field[1], field[2], field[3]]))
}

fn size_at(bytes: &[u8], at: usize) -> Option<usize> {
    u32_at(bytes, at).map(|size| size as usize)
}

/// The members by name, in the directory's order.
pub(crate) fn directory(bytes: &[u8]) -> Result<Vec<(String, Member)>, Fault> {
    let end = find_end(bytes).ok_or(Fault {
        offset: bytes.len(),
        problem: "no end-of-directory record; the file is cut short or is no zip file",
    })?;
    let fault = |offset, problem| Fault { offset, problem };
    let cut = || fault(end, "the end-of-directory record is cut short");
    let count = u16_at(bytes, end + 10).ok_or_else(cut)?;
    let mut at = size_at(bytes, end + 16).ok_or_else(cut)?;
    if count == u16::MAX || at == u32::MAX as usize {
        return Err(fault(end, "uses the zip64 extension; keep archives below 4 GiB"));
    }
    let mut members = Vec::new();
    for _ in 0..count {
        let (name, member, next) = entry(bytes, at).ok_or(fault(at, "a directory entry is damaged or cut short"))?;
        members.push((name, member));
        at = next;
    }
    Ok(members)
}

/// Position of the end-of-directory record, searched from the back past a possible comment.
fn find_end(bytes: &[u8]) -> Option<usize> {
    let last = bytes.len().checked_sub(DIRECTORY_END_SIZE)?;
    let first = last.saturating_sub(LONGEST_COMMENT);
    (first..=last).rev().find(|&at| u32_at(bytes, at) == Some(DIRECTORY_END))
}

/// One directory entry and the position of the next.
fn entry(bytes: &[u8], at: usize) -> Option<(String, Member, usize)> {
    if u32_at(bytes, at)? != DIRECTORY_ENTRY {
        return None;
    }
    let member = Member {
        flags: u16_at(bytes, at + 8)?,
        method: u16_at(bytes, at + 10)?,
        crc: u32_at(bytes, at + 16)?,
        packed: size_at(bytes, at + 20)?,
        unpacked: size_at(bytes, at + 24)?,
        header: size_at(bytes, at + 42)?,
    };
    let name_end = at + DIRECTORY_ENTRY_SIZE + usize::from(u16_at(bytes, at + 28)?);
    let name = bytes.get(at + DIRECTORY_ENTRY_SIZE..name_end)?;
    let name = String::from_utf8(name.to_vec()).ok()?;
    let extra = usize::from(u16_at(bytes, at + 30)?);
    let comment = usize::from(u16_at(bytes, at + 32)?);
    Some((name, member, name_end + extra + comment))
}

impl Member {
    /// The member's bytes, decompressed and checked.
    pub(crate) fn read(&self, archive: &[u8]) -> Result<Vec<u8>, MemberProblem> {
        if self.flags & 1 != 0 {
            return Err(MemberProblem::Encrypted);
        }
        let packed = self.packed_bytes(archive)?;
        let bytes = match self.method {
            STORED if self.packed == self.unpacked => packed.to_vec(),
            STORED => {
                let (needed, found) = (self.unpacked, self.packed);
                return Err(MemberProblem::Truncated { needed, found });
            }
            DEFLATED => self.inflate(packed)?,
            method => return Err(MemberProblem::Compression { method }),
        };
        let computed = crc32fast::hash(&bytes);
        if computed != self.crc {
            return Err(MemberProblem::Checksum { stored: self.crc, computed });
        }
        Ok(bytes)
    }

    fn packed_bytes<'a>(&self, archive: &'a [u8]) -> Result<&'a [u8], MemberProblem> {
        let truncated = || MemberProblem::Truncated {
            needed: self.header.saturating_add(LOCAL_HEADER_SIZE).saturating_add(self.packed),
            found: archive.len(),
        };
        let header = self.header;
        if u32_at(archive, header).ok_or_else(truncated)? != LOCAL_HEADER {
            let problem = "the zip directory does not point to a member";
            return Err(MemberProblem::Header { problem });
        }
        let name = usize::from(u16_at(archive, header + 26).ok_or_else(truncated)?);
        let extra = usize::from(u16_at(archive, header + 28).ok_or_else(truncated)?);
        let start = header + LOCAL_HEADER_SIZE + name + extra;
        start.checked_add(self.packed).and_then(|end| archive.get(start..end)).ok_or_else(truncated)
    }

    /// Inflates with memory in proportion to what the stream really holds, never more than declared.
    fn inflate(&self, packed: &[u8]) -> Result<Vec<u8>, MemberProblem> {
        miniz_oxide::inflate::decompress_to_vec_with_limit(packed, self.unpacked)
            .ok()
            .filter(|bytes| bytes.len() == self.unpacked)
            .ok_or(MemberProblem::Inflate { declared: self.unpacked })
    }
}

/// A zip archive of stored members; `None` when it exceeds the format without extensions.
pub(crate) fn pack<'a>(members: impl Iterator<Item = (&'a str, &'a [u8])>) -> Option<Vec<u8>> {
    let mut archive = Vec::new();
    let mut directory = Vec::new();
    let mut count: u16 = 0;
    for (name, bytes) in members {
        count = count.checked_add(1).filter(|&count| count < u16::MAX)?;
        let header = u32::try_from(archive.len()).ok()?;
        let fields = common_fields(name, bytes)?;
        archive.extend(LOCAL_HEADER.to_le_bytes());
        archive.extend(&fields);
        archive.extend(name.as_bytes());
        archive.extend(bytes);
        directory.extend(DIRECTORY_ENTRY.to_le_bytes());
        directory.extend(20u16.to_le_bytes());
        directory.extend(&fields);
        directory.extend([0; 10]);
        directory.extend(header.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let start = u32::try_from(archive.len()).ok().filter(|&start| start < u32::MAX)?;
    let size = u32::try_from(directory.len()).ok()?;
    archive.extend(directory);
    archive.extend(DIRECTORY_END.to_le_bytes());
    archive.extend([0; 4]);
    archive.extend(count.to_le_bytes());
    archive.extend(count.to_le_bytes());
    archive.extend(size.to_le_bytes());
    archive.extend(start.to_le_bytes());
    archive.extend([0; 2]);
    Some(archive)
}

/// The 26 bytes that a local header and a directory entry share: version needed to the length of
/// the extra field.
fn common_fields(name: &str, bytes: &[u8]) -> Option<Vec<u8>> {
    let size = u32::try_from(bytes.len()).ok()?;
    let mut fields = Vec::with_capacity(26);
    fields.extend(20u16.to_le_bytes());
    fields.extend([0; 2]);
    fields.extend(STORED.to_le_bytes());
    fields.extend([0; 2]);
    fields.extend(NO_DATE.to_le_bytes());
    fields.extend(crc32fast::hash(bytes).to_le_bytes());
    fields.extend(size.to_le_bytes());
    fields.extend(size.to_le_bytes());
    fields.extend(u16::try_from(name.len()).ok()?.to_le_bytes());
    fields.extend([0; 2]);
    Some(fields)
}
