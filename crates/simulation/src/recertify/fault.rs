//! What can be wrong with a recorded step besides its laws.

/// Something in a frame that does not follow from model, state and solution, or that keeps it from being checked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StepFault {
    /// The step was made without a solution.
    #[error("it holds no solution")]
    NoSolution,
    /// State, input or problem cannot be used.
    #[error("{0}")]
    Unusable(String),
    /// The recorded contacts are not among those of the recorded configuration, in their order.
    #[error("it has {recorded} contacts, of which the configuration has {found}")]
    Contacts {
        /// Contacts of the frame.
        recorded: usize,
        /// Those that were found anew, up to the first that is not there.
        found: usize,
    },
    /// A contact or limit is not where the configuration has it.
    #[error("contact {contact}: {what} is off by {difference:.1e}")]
    Contact {
        /// Index of the contact; limits come after the contact points.
        contact: usize,
        /// What of it.
        what: &'static str,
        /// Largest difference, m or without unit.
        difference: f64,
    },
    /// The impulse that a contact or limit shows is not that of the solution.
    #[error("contact {contact}: its impulse is off by {difference:.1e} N·s from that of the solution")]
    Impulse {
        /// Index of the contact; limits come after the contact points.
        contact: usize,
        /// Largest difference, N·s.
        difference: f64,
    },
    /// A pose is not that of the configuration.
    #[error("the pose of body {body} is off by {difference:.1e} from that of the configuration")]
    Pose {
        /// Index of the body.
        body: usize,
        /// Largest difference, m or without unit.
        difference: f64,
    },
    /// The energy is not that of the state.
    #[error("its energy is off by {difference:.1e} J from that of the state")]
    Energy {
        /// Larger difference of the two, J.
        difference: f64,
    },
    /// The velocity crosses a limit that the problem does not have.
    #[error("its velocity crosses a limit that is not in the problem")]
    CrossedLimit,
    /// The velocity closes a contact that the problem does not have.
    #[error("its velocity closes a contact that is not in the problem")]
    CrossedContact,
    /// A body moves farther than contacts were looked for.
    #[error("a body moves farther than contacts were looked for")]
    Reach,
    /// The part θ of overlaps that the step removes is none.
    #[error("it removes the part {theta} of its overlaps, which is not in [0, 1)")]
    Theta {
        /// What the frame says.
        theta: f64,
    },
    /// An impact has its decompression by Poisson's law of restitution, and nothing else has.
    #[error("it has {recorded} phases, its impacts ask for {}", 3 - recorded)]
    Phases {
        /// Phases of the frame.
        recorded: u8,
    },
    /// An array of the solution does not fit the problem.
    #[error("its {array} has {found} entries, the problem asks for {expected}")]
    Length {
        /// The array.
        array: &'static str,
        /// What the problem asks for.
        expected: usize,
        /// What the frame has.
        found: usize,
    },
}
