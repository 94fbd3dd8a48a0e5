//! Every method by its name.

use std::fmt;
use std::str::FromStr;

use crate::{
    Automatic, Enumeration, EnumerationSettings, LcpError, Lemke, LemkeSettings, Method, NewtonMap, PrincipalPivoting,
    PrincipalPivotingSettings, Psor, PsorSettings, SemismoothNewton, SemismoothNewtonSettings,
};

/// The methods by name, each with its settings.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MethodKind {
    /// Lemke, then on tiny problems enumeration, `"automatic"`.
    Automatic(LemkeSettings, EnumerationSettings),
    /// Lexicographic Lemke, `"lemke"`.
    Lemke(LemkeSettings),
    /// All complementary bases, `"enumeration"`.
    Enumeration(EnumerationSettings),
    /// Cottle and Dantzig's principal pivoting, `"principal-pivoting"`.
    PrincipalPivoting(PrincipalPivotingSettings),
    /// Projected successive overrelaxation, `"psor"`.
    Psor(PsorSettings),
    /// Semismooth Newton, `"newton-fischer-burmeister"` or `"newton-minimum"` by its map.
    SemismoothNewton(SemismoothNewtonSettings),
}

/// The names of all methods, for messages.
const NAMES: &str =
    "automatic, lemke, enumeration, principal-pivoting, psor, newton-fischer-burmeister, newton-minimum";

impl MethodKind {
    /// Every method with its default settings.
    pub fn all() -> Vec<Self> {
        let newton =
            |map| Self::SemismoothNewton(SemismoothNewtonSettings { map, ..SemismoothNewtonSettings::default() });
        vec![
            Self::Automatic(LemkeSettings::default(), EnumerationSettings::default()),
            Self::Lemke(LemkeSettings::default()),
            Self::Enumeration(EnumerationSettings::default()),
            Self::PrincipalPivoting(PrincipalPivotingSettings::default()),
            Self::Psor(PsorSettings::default()),
            newton(NewtonMap::FischerBurmeister),
            newton(NewtonMap::Minimum),
        ]
    }

    /// The method, ready to solve.
    ///
    /// # Errors
    /// [`LcpError::Setting`] when a setting is outside its range.
    pub fn build(&self) -> Result<Box<dyn Method>, LcpError> {
        Ok(match self {
            Self::Automatic(lemke, enumeration) => Box::new(Automatic::new(lemke.clone(), enumeration.clone())?),
            Self::Lemke(settings) => Box::new(Lemke::new(settings.clone())?),
            Self::Enumeration(settings) => Box::new(Enumeration::new(settings.clone())?),
            Self::PrincipalPivoting(settings) => Box::new(PrincipalPivoting::new(settings.clone())?),
            Self::Psor(settings) => Box::new(Psor::new(settings.clone())?),
            Self::SemismoothNewton(settings) => Box::new(SemismoothNewton::new(settings.clone())?),
        })
    }
}

impl fmt::Display for MethodKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Automatic(..) => "automatic",
            Self::Lemke(_) => "lemke",
            Self::Enumeration(_) => "enumeration",
            Self::PrincipalPivoting(_) => "principal-pivoting",
            Self::Psor(_) => "psor",
            Self::SemismoothNewton(settings) => match settings.map {
                NewtonMap::FischerBurmeister => "newton-fischer-burmeister",
                NewtonMap::Minimum => "newton-minimum",
            },
        })
    }
}

impl FromStr for MethodKind {
    type Err = LcpError;

    /// The method of this name with its default settings.
    fn from_str(name: &str) -> Result<Self, LcpError> {
        Self::all()
            .into_iter()
            .find(|kind| kind.to_string() == name)
            .ok_or_else(|| LcpError::UnknownMethod { name: name.to_owned(), known: NAMES })
    }
}
