//! How a key is declared: once, with its field, its name in the file, its range and its meaning. From that line come
//! the type, the check of what a file says, the file of record, `fsi-driver keys` and the schema for editors.

/// An enumeration whose variants are words of a file, as in [`fsi_numerics::words!`], for keys that may be absent.
#[macro_export]
macro_rules! words {
    ($(#[$meta:meta])* $visibility:vis enum $enum:ident { $($variants:tt)* }) => {
        fsi_numerics::words! { $(#[$meta])* $visibility enum $enum { $($variants)* } }

        impl $crate::table::Absent for $enum {}
    };
}

/// A table of a file as a type. A key is a line `field: Type = "name_unit", kind, "meaning";`, with `, absent "what
/// counts then"` if it may be and `, only CONDITION` if not every case reads it (`case/conditions.rs`); a table in it
/// is a line `[field: Type, "meaning"]`, perhaps with the same two.
#[macro_export]
macro_rules! table {
    (
        $(#[$meta:meta])*
        $visibility:vis struct $struct:ident {
            $(
                $(#[$more:meta])*
                $field:ident: $type:ty = $name:literal, $kind:expr, $about:literal $(, absent $absent:literal)? $(, only $only:ident)?;
            )*
            $([$table:ident: $inner:ty, $about_table:literal $(, absent $absent_table:literal)? $(, only $only_table:ident)?])*
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        $visibility struct $struct {
            $(
                #[doc = concat!("`", $name, "`: ", $about, ".")]
                $(#[$more])*
                #[serde(rename = $name)]
                $(
                    #[doc = concat!("If absent: ", $absent, ".")]
                    #[serde(default, skip_serializing_if = "fsi_case::table::Absent::is_absent")]
                )?
                pub $field: $type,
            )*
            $(
                #[doc = concat!("`[", stringify!($table), "]`: ", $about_table, ".")]
                $(
                    #[doc = concat!("If absent: ", $absent_table, ".")]
                    #[serde(default)]
                )?
                pub $table: $inner,
            )*
        }

        impl $crate::schema::KeyTable for $struct {
            fn describe(path: &str, schema: &mut $crate::schema::Schema) {
                #[allow(unused_imports)] // not every table has both
                use $crate::schema::{Key, KeyTable, join};
                $(
                    schema.add(Key {
                        path: join(path, $name),
                        kind: $kind,
                        absent: None$(.or(Some($absent)))?,
                        about: $about,
                        choices: Vec::new(),
                        problems: &[],
                        only: vec![$($crate::conditions::$only)?],
                    });
                )*
                $(schema.only(&[$($crate::conditions::$only_table)?], |schema| {
                    <$inner as KeyTable>::describe(&join(path, stringify!($table)), schema);
                });)*
            }
        }
    };
}

/// A table of which there are several kinds, each with keys of its own, as an enumeration: one key, the tag, says
/// which.
macro_rules! choice {
    (
        $(#[$meta:meta])*
        $visibility:vis enum $enum:ident by $tag:literal, $about_tag:literal {
            $(
                $(#[doc = $doc:literal])+
                $variant:ident = $word:literal {
                    $($field:ident: $type:ty = $name:literal, $kind:expr, $about:literal $(, absent $absent:literal)?;)*
                }
            )+
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(tag = $tag, deny_unknown_fields)]
        $visibility enum $enum {
            $(
                $(#[doc = $doc])+
                #[serde(rename = $word)]
                $variant {
                    $(
                        #[doc = concat!("`", $name, "`: ", $about, ".")]
                        #[serde(rename = $name)]
                        $(
                            #[doc = concat!("If absent: ", $absent, ".")]
                            #[serde(default, skip_serializing_if = "fsi_case::table::Absent::is_absent")]
                        )?
                        $field: $type,
                    )*
                },
            )+
        }

        impl $enum {
            /// The word of each in files, and what it means.
            pub const WORDS: &'static [(&'static str, &'static str)] =
                &[$(($word, concat!($($doc),+).trim_ascii())),+];
        }

        impl $crate::schema::KeyTable for $enum {
            fn describe(path: &str, schema: &mut $crate::schema::Schema) {
                use $crate::schema::{Choice, Key, ValueKind, join};
                schema.add(Key {
                    path: join(path, $tag),
                    kind: ValueKind::Word(Self::WORDS),
                    absent: None,
                    about: $about_tag,
                    choices: Vec::new(),
                    problems: &[],
                    only: Vec::new(),
                });
                $($(
                    schema.add(Key {
                        path: join(path, $name),
                        kind: $kind,
                        absent: None$(.or(Some($absent)))?,
                        about: $about,
                        choices: vec![Choice { tag: $tag, word: $word }],
                        problems: &[],
                        only: Vec::new(),
                    });
                )*)+
            }
        }
    };
}

pub(crate) use choice;

/// Values of keys that may be absent.
pub trait Absent {
    /// Whether the key is left out of the file of record.
    fn is_absent(&self) -> bool {
        false
    }
}

impl Absent for bool {}

impl Absent for f64 {}

impl Absent for fsi_coupling::convergence::ConvergenceQuantity {}

impl Absent for fsi_pfem::Formulation {}

impl Absent for fsi_pfem::element::surface::LoadKind {}

impl Absent for fsi_pfem::solution::time_scheme::TimeScheme {}

impl<T> Absent for Option<T> {
    fn is_absent(&self) -> bool {
        self.is_none()
    }
}

impl<T> Absent for Vec<T> {
    fn is_absent(&self) -> bool {
        self.is_empty()
    }
}
