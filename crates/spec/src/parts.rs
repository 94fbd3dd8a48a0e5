//! Lists of parts with stable places.

use crate::SpecError;

/// A part with a name.
pub(crate) trait Named {
    /// What messages call it.
    const SORT: &'static str;
    fn name(&self) -> &str;
    fn rename(&mut self, name: String);
}

macro_rules! named {
    ($($part:ty, $sort:literal;)*) => {
        $(impl Named for $part {
            const SORT: &'static str = $sort;
            fn name(&self) -> &str {
                &self.name
            }
            fn rename(&mut self, name: String) {
                self.name = name;
            }
        })*
    };
}
named! {
    signorini_multibody::Body, "body";
    signorini_multibody::Joint, "joint";
    signorini_multibody::Geom, "geom";
    signorini_multibody::Site, "site";
    signorini_multibody::Tendon, "tendon";
    signorini_multibody::Actuator, "actuator";
    signorini_multibody::Sensor, "sensor";
    signorini_multibody::Equality, "equality constraint";
    signorini_multibody::Camera, "camera";
    signorini_multibody::Light, "light";
    crate::KeyframeSpec, "keyframe";
}

/// Parts of a sort; a place stays empty once its part is removed.
#[derive(Clone, Debug)]
pub(crate) struct Parts<T>(Vec<Option<T>>);

impl<T> Default for Parts<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T: Named> Parts<T> {
    pub fn of(list: impl IntoIterator<Item = T>) -> Self {
        Self(list.into_iter().map(Some).collect())
    }

    /// Places, empty ones included.
    pub fn places(&self) -> usize {
        self.0.len()
    }

    pub fn iter(&self) -> impl DoubleEndedIterator<Item = (usize, &T)> {
        self.0.iter().enumerate().filter_map(|(i, part)| Some((i, part.as_ref()?)))
    }

    pub fn get(&self, place: usize) -> Option<&T> {
        self.0.get(place)?.as_ref()
    }

    pub fn find(&self, name: &str) -> Result<usize, SpecError> {
        let found = self.iter().find(|(_, part)| part.name() == name);
        found.map(|(place, _)| place).ok_or_else(|| SpecError::UnknownName {
            sort: T::SORT,
            name: name.to_owned(),
            similar: most_similar(name, self.iter().map(|(_, part)| part.name())),
        })
    }

    pub fn named_mut(&mut self, name: &str) -> Result<&mut T, SpecError> {
        let place = self.find(name)?;
        self.0[place].as_mut().ok_or_else(|| SpecError::UnknownName { sort: T::SORT, name: name.into(), similar: None })
    }

    pub fn add(&mut self, part: T) -> Result<usize, SpecError> {
        if self.iter().any(|(_, other)| other.name() == part.name()) {
            return Err(SpecError::DuplicateName { sort: T::SORT, name: part.name().to_owned() });
        }
        self.0.push(Some(part));
        Ok(self.0.len() - 1)
    }

    /// Changes all parts.
    pub fn change(&mut self, change: impl FnMut(&mut T)) {
        self.0.iter_mut().flatten().for_each(change);
    }

    /// Removes the parts that are not wanted and lists them.
    pub fn retain(&mut self, wanted: impl Fn(usize, &T) -> bool, removed: &mut Vec<String>) {
        for (i, place) in self.0.iter_mut().enumerate() {
            if place.as_ref().is_some_and(|part| !wanted(i, part))
                && let Some(part) = place.take()
            {
                removed.push(format!("{} '{}'", T::SORT, part.name()));
            }
        }
    }
}

/// The name with the smallest edit distance, if that is small.
fn most_similar<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> Option<String> {
    let distance = |other: &str| {
        let (a, b): (Vec<char>, Vec<char>) = (name.chars().take(100).collect(), other.chars().take(100).collect());
        let mut row: Vec<usize> = (0..=b.len()).collect();
        for (i, x) in a.iter().enumerate() {
            let mut diagonal = std::mem::replace(&mut row[0], i + 1);
            for (j, y) in b.iter().enumerate() {
                let substitute = diagonal + usize::from(x != y);
                diagonal = row[j + 1];
                row[j + 1] = substitute.min(diagonal + 1).min(row[j] + 1);
            }
        }
        row[b.len()]
    };
    let (nearest, best) = known.map(|other| (distance(other), other)).min()?;
    (nearest <= 1 + name.len() / 4).then(|| best.to_owned())
}
