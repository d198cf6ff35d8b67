//! Enumerations whose variants have codes and names.

/// Writes an enumeration with the name of each variant, and the list of all in the order of their codes.
macro_rules! named {
    ($(#[$doc:meta])* pub enum $type:ident {
        $($(#[$variant_doc:meta])* $variant:ident $(= $code:literal)? => $name:literal,)*
    }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u8)]
        pub enum $type {
            $($(#[$variant_doc])* $variant $(= $code)?,)*
        }

        impl $type {
            /// All, in the order of their codes.
            pub const ALL: [$type; [$($name),*].len()] = [$($type::$variant),*];

            /// The name that users see.
            pub fn name(self) -> &'static str {
                match self {
                    $($type::$variant => $name,)*
                }
            }
        }
    };
}
pub(crate) use named;
