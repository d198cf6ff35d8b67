//! Which kernels there are: what moves, by which table, and what is watched.

use crate::method::{self, Composition, Form, Numbers};
use crate::model::{Attitude, Axis, AxisAttitude, DrivenFrame, DrivenRates, Layout, Rates, TwoAxes};

/// Which model moves and what is carried beside the rates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // The names are those of `model`.
pub enum System {
    FreeRates,
    FreeAxis,
    FreeAttitude,
    TopAxis,
    TopTwoAxes,
    TopAttitude,
    SpinFreeAxis,
    SpinFreeTwoAxes,
    SpinFreeAttitude,
    DrivenRates,
    DrivenFrame,
}

macro_rules! tables {
    ($($smooth:ident)*; $($split:ident)*; $($stiff:ident)*) => {
        /// Which table moves it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(missing_docs)] // The names are those of `method`.
        pub enum Table {
            $($smooth,)*
            $($split,)*
            $($stiff,)*
        }
        impl Table {
            /// All tables.
            pub const ALL: [Table; [$(Table::$smooth,)* $(Table::$split,)* $(Table::$stiff),*].len()] =
                [$(Table::$smooth,)* $(Table::$split,)* $(Table::$stiff),*];

            /// Whether it takes steps along the equations of motion, not by exact flows of their parts.
            pub fn is_smooth(self) -> bool {
                matches!(self, $(Table::$smooth)|*)
            }

            /// Whether it is for damping of any strength.
            pub fn is_stiff(self) -> bool {
                matches!(self, $(Table::$stiff)|*)
            }

            /// Its numbers, if it is a splitting.
            pub(super) fn numbers(self) -> &'static Numbers {
                match self {
                    $(Table::$split => const { &<method::$split as Composition>::NUMBERS },)*
                    _ => &NO_NUMBERS,
                }
            }
        }
    };
}
pub(super) const NO_NUMBERS: Numbers = Numbers::of(&[]);
tables! {
    Rk4 Dop853 Taylor8 Taylor12 Taylor16 Taylor20 Taylor26;
    Planar Planar4 Planar6 Planar8
    Rotor Rotor4 Rotor6 Rotor8 Chin4a Srkn6 Srkn11 Srkn14 Pmlf4 Pmlf6
    DmvChin4a DmvSrkn6 DmvSrkn11 DmvSrkn14 DmvPmlf4 DmvPmlf6
    Dmv2 Dmv4 Dmv6 Dmv8 Dmv10;
    Affine Etd4 Midpoint
}

/// What is looked at after each step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // The names are those of `observe`.
pub enum Watch {
    Nothing,
    Flips,
    Tilt,
}

/// A kernel: system, table and observable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kernel {
    /// What moves.
    pub system: System,
    /// How.
    pub table: Table,
    /// What is watched.
    pub watch: Watch,
}

impl System {
    /// Numbers in the state.
    #[allow(clippy::len_without_is_empty)] // No state is empty.
    pub fn len(self) -> usize {
        match self {
            System::FreeRates => Rates::LEN,
            System::FreeAxis | System::TopAxis | System::SpinFreeAxis => Axis::LEN,
            System::FreeAttitude => Attitude::LEN,
            System::TopTwoAxes | System::SpinFreeTwoAxes => TwoAxes::LEN,
            System::TopAttitude | System::SpinFreeAttitude => AxisAttitude::LEN,
            System::DrivenRates => DrivenRates::LEN,
            System::DrivenFrame => DrivenFrame::LEN,
        }
    }

    /// Whether there may be weight; the vertical is then the first direction carried.
    pub fn is_top(self) -> bool {
        use System::*;
        !matches!(self, FreeRates | FreeAxis | FreeAttitude | DrivenRates)
    }

    /// Whether something acts from outside; work, impulse and time are then the last numbers of the state.
    pub fn is_driven(self) -> bool {
        matches!(self, System::DrivenRates | System::DrivenFrame)
    }

    /// Whether a direction is carried.
    pub fn has_direction(self) -> bool {
        !matches!(self, System::FreeRates | System::FreeAttitude | System::DrivenRates)
    }

    /// Whether the attitude is carried as rows of its matrix: the third, which is the vertical, then the first.
    pub fn has_rows(self) -> bool {
        matches!(self, System::TopTwoAxes | System::SpinFreeTwoAxes | System::DrivenFrame)
    }

    /// Whether this can be watched: sign changes of the rates, or the tilt from a direction carried.
    pub fn shows(self, watch: Watch) -> bool {
        match watch {
            Watch::Nothing => true,
            Watch::Flips => self.is_driven() || matches!(self, System::FreeRates | System::TopAxis),
            Watch::Tilt => {
                use System::*;
                matches!(self, FreeAxis | TopAxis | TopTwoAxes | DrivenFrame)
            }
        }
    }

    /// Where the quaternion begins, if one is carried.
    pub fn quaternion_at(self) -> Option<usize> {
        match self {
            System::FreeAttitude => Some(Attitude::QUATERNION_AT),
            System::TopAttitude | System::SpinFreeAttitude => Some(AxisAttitude::QUATERNION_AT),
            _ => None,
        }
    }
}

impl Table {
    /// Whether it moves that system. The oldest schemes are kept in the frame of the body, as they were published;
    /// kicks need weight, drifts alone do not know it.
    pub fn moves(self, system: System) -> bool {
        use System::*;
        let spin_free = matches!(system, SpinFreeAxis | SpinFreeTwoAxes | SpinFreeAttitude);
        if system.is_driven() {
            return self.is_smooth() || self.is_stiff();
        }
        match self {
            Table::Affine | Table::Etd4 => false,
            Table::Midpoint => !spin_free && system != TopAttitude,
            Table::Rk4 | Table::Planar | Table::Planar4 | Table::Planar6 | Table::Planar8 | Table::Rotor => {
                !spin_free
            }
            _ if self.carries_rows() => !matches!(system, TopAttitude | SpinFreeAttitude),
            _ if self.is_drift() => matches!(system, FreeRates | FreeAxis | FreeAttitude),
            _ if system == SpinFreeTwoAxes || (self.is_processed() && system == TopTwoAxes) => false,
            _ if self.is_for_symmetric() => system.is_top(),
            _ => system.is_top() && !spin_free,
        }
    }

    /// Whether it carries the attitude of a top as two rows of its matrix: the vertical, which the torque needs
    /// anyway, and another direction cost less than the vertical and a quaternion.
    pub fn carries_rows(self) -> bool {
        (self.is_smooth() && self != Table::Rk4) || self == Table::Midpoint
    }

    /// Whether it moves bodies symmetric about their axis 3 only.
    pub fn is_for_symmetric(self) -> bool {
        use Table::*;
        matches!(self, Rotor | Rotor4 | Rotor6 | Rotor8 | Chin4a | Srkn6 | Srkn11 | Srkn14 | Pmlf4 | Pmlf6)
    }

    /// Whether it is free motion alone.
    fn is_drift(self) -> bool {
        use Table::*;
        matches!(self, Dmv2 | Dmv4 | Dmv6 | Dmv8 | Dmv10)
    }

    /// Whether its steps are made in other variables than the state: nothing can be watched on the way.
    pub fn is_processed(self) -> bool {
        use Table::*;
        matches!(self, Pmlf4 | Pmlf6 | DmvPmlf4 | DmvPmlf6)
    }

    /// What is left of it in a scene without weight: the drift alone.
    pub fn without_weight(self) -> Table {
        use Table::*;
        match self {
            DmvChin4a | DmvSrkn6 | DmvSrkn11 | DmvSrkn14 | DmvPmlf4 | DmvPmlf6 => Dmv10,
            _ if self.is_for_symmetric() => Rotor,
            _ => self,
        }
    }

    /// The table whose code it shares.
    pub fn engine(self) -> Table {
        use Table::*;
        match self {
            Planar => Planar,
            _ if self.is_smooth() || self.is_stiff() => self,
            Planar4 | Planar6 | Planar8 => Planar8,
            _ if self.is_for_symmetric() => Rotor,
            _ => Dmv10,
        }
    }

    /// The variables that it moves.
    pub fn form(self) -> Form {
        match self {
            Table::Etd4 => Form::Rates,
            _ if self.is_smooth() => Form::Rates,
            _ => Form::Momenta,
        }
    }
}
