//! Enumerations whose variants are words of a file.

/// An enumeration whose variants are words of a file; their docs are the words' meanings.
/// The crate that uses it depends on `serde`.
#[macro_export]
macro_rules! words {
    (
        $(#[$meta:meta])*
        $visibility:vis enum $enum:ident {
            $($(#[doc = $about:literal])+ $variant:ident = $word:literal $(($default:ident))?,)+
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
        $visibility enum $enum {
            $($(#[doc = $about])+ #[serde(rename = $word)] $(#[$default])? $variant,)+
        }

        impl $enum {
            /// All of them.
            pub const ALL: [Self; [$($word),+].len()] = [$(Self::$variant),+];
            /// The word of each in files, and what it means.
            pub const WORDS: &'static [(&'static str, &'static str)] =
                &[$(($word, concat!($($about),+).trim_ascii())),+];

            /// The word in files, in tables and on the command line.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)+
                }
            }
        }

        impl std::fmt::Display for $enum {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}
