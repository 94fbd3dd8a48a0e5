//! XML text, element by element.

use signorini_multibody::Pose;

/// An element being written.
pub(super) struct Tag {
    name: &'static str,
    attributes: String,
    children: Vec<Tag>,
}

impl Tag {
    pub fn new(name: &'static str) -> Self {
        Self { name, attributes: String::new(), children: Vec::new() }
    }

    /// Adds an attribute.
    pub fn with(mut self, name: &str, value: &str) -> Self {
        self.set(name, value);
        self
    }

    pub fn set(&mut self, name: &str, value: &str) {
        self.attributes.push(' ');
        self.attributes.push_str(name);
        self.attributes.push_str("=\"");
        for c in value.chars() {
            match c {
                '&' => self.attributes.push_str("&amp;"),
                '<' => self.attributes.push_str("&lt;"),
                '"' => self.attributes.push_str("&quot;"),
                '\n' => self.attributes.push_str("&#10;"),
                '\t' => self.attributes.push_str("&#9;"),
                _ => self.attributes.push(c),
            }
        }
        self.attributes.push('"');
    }

    /// Adds numbers, each with the digits that give the same number again.
    pub fn numbers(mut self, name: &str, values: &[f64]) -> Self {
        self.set(name, &list(values));
        self
    }

    /// Adds numbers that are not `neutral`.
    pub fn unless(self, neutral: &[f64], name: &str, values: &[f64]) -> Self {
        if values == neutral { self } else { self.numbers(name, values) }
    }

    /// Adds a range, and that it counts.
    pub fn range(self, name: &str, limited: &str, range: Option<[f64; 2]>) -> Self {
        match range {
            Some(range) => self.with(limited, "true").numbers(name, &range),
            None => self,
        }
    }

    pub fn push(&mut self, child: Tag) {
        self.children.push(child);
    }

    /// Adds a child that has something to say.
    pub fn push_filled(&mut self, child: Tag) {
        if !child.children.is_empty() {
            self.push(child);
        }
    }

    /// The text, with two spaces for every level.
    pub fn text(&self) -> String {
        let mut out = String::new();
        self.write(0, &mut out);
        out
    }

    fn write(&self, level: usize, out: &mut String) {
        let indent = "  ".repeat(level);
        out.push_str(&format!("{indent}<{}{}", self.name, self.attributes));
        if self.children.is_empty() {
            return out.push_str("/>\n");
        }
        out.push_str(">\n");
        self.children.iter().for_each(|child| child.write(level + 1, out));
        out.push_str(&format!("{indent}</{}>\n", self.name));
    }
}

/// Numbers with spaces between them.
pub(super) fn list(values: &[f64]) -> String {
    let number = |x: &f64| {
        let text = format!("{x:?}");
        text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
    };
    values.iter().map(number).collect::<Vec<_>>().join(" ")
}

/// Adds a pose.
pub(super) fn placed(tag: Tag, pose: &Pose) -> Tag {
    let r = pose.rotation;
    let quaternion = [r.w, r.x, r.y, r.z];
    tag.unless(&[0.0; 3], "pos", &pose.position.to_array()).unless(&[1.0, 0.0, 0.0, 0.0], "quat", &quaternion)
}
