//! One definition for a payload's memory layout and its schema.
//!
//! The macro `wire_message!` writes a `#[repr(C)]` struct and the list of its fields from the same lines.
//! The list gives the `ros2msg` schema text and the layout identity. The derive of
//! [`zerocopy::IntoBytes`] refuses a struct with padding at compile time, and the field order
//! (eight-byte fields first) makes the C offsets equal the CDR ones, so that the bytes of the
//! struct are the body of a CDR message (OMG DDS-XTypes 1.3, §7.4.3, plain CDR, little endian).

use std::fmt::Write as _;

/// The four bytes before a CDR body: representation "plain CDR, little endian", no options.
pub const CDR_LITTLE_ENDIAN_HEADER: [u8; 4] = [0, 1, 0, 0];

/// A type that can be a field of a wire message.
pub trait WireField {
    /// The field's type in a `ros2msg` schema, such as `float64` or `uint64[32]`.
    fn ros_type() -> String;
    /// Definitions that the schema must carry for this type, innermost last.
    fn nested_definitions() -> Vec<(&'static str, String)> {
        Vec::new()
    }
}

macro_rules! scalar {
    ($($rust:ty => $ros:literal),+) => {
        $(impl WireField for $rust { fn ros_type() -> String { $ros.to_owned() } })+
    };
}
scalar!(u64 => "uint64", i64 => "int64", f64 => "float64", u32 => "uint32");

impl<T: WireField, const N: usize> WireField for [T; N] {
    fn ros_type() -> String {
        format!("{}[{N}]", T::ros_type())
    }
    fn nested_definitions() -> Vec<(&'static str, String)> {
        T::nested_definitions()
    }
}

/// One field of a wire message, as the schema shows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Name; carries the unit where there is one (`torque_mnm`).
    pub name: &'static str,
    /// Type in the `ros2msg` schema.
    pub ros_type: String,
    /// Offset in the struct, which is also the offset in the CDR body, bytes.
    pub offset: usize,
    /// What the field is, in one line.
    pub comment: String,
}

/// A payload whose bytes are the CDR body of its schema.
pub trait WireMessage: zerocopy::IntoBytes + zerocopy::Immutable + Sized {
    /// Schema name, as `package/msg/Name`.
    const SCHEMA_NAME: &'static str;

    /// The fields in the order of their bytes.
    fn fields() -> Vec<Field>;

    /// Definitions of the message types that the fields use.
    fn nested_definitions() -> Vec<(&'static str, String)>;

    /// The `ros2msg` schema text: the fields with their comments, then nested definitions.
    #[must_use]
    fn schema_text() -> String {
        let mut text = field_lines(&Self::fields());
        for (name, definition) in Self::nested_definitions() {
            // A definition is named `package/Name`, without the `msg` folder of its file.
            let name = name.replace("/msg/", "/");
            let _ = write!(text, "{}\nMSG: {name}\n{definition}", "=".repeat(80));
        }
        text
    }

    /// Identity of the layout: FNV-1a (64 bit) over the schema's types and names.
    ///
    /// Comments do not count, so that a reworded comment does not part two processes.
    #[must_use]
    fn layout_id() -> u64 {
        let types_and_names: String = Self::schema_text()
            .lines()
            .flat_map(|line| [line.split('#').next().unwrap_or_default().trim_end(), "\n"])
            .collect();
        fnv1a(types_and_names.as_bytes())
    }

    /// The message's bytes as they lie in shared memory: the CDR body.
    fn wire_bytes(&self) -> &[u8] {
        zerocopy::IntoBytes::as_bytes(self)
    }
}

/// The lines of a `ros2msg` definition for `fields`.
pub(crate) fn field_lines(fields: &[Field]) -> String {
    fields.iter().fold(String::new(), |mut text, field| {
        let _ = writeln!(text, "{} {}  # {}", field.ros_type, field.name, field.comment);
        text
    })
}

/// FNV-1a, 64 bit: a short name for a long one.
pub(crate) fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Defines a payload: the struct, its schema and its layout, from one list of fields.
///
/// Fields of eight bytes come first, then an even number of `u32`, so that there is no padding.
macro_rules! wire_message {
    (
        $(#[doc = $doc:literal])*
        pub struct $name:ident as $schema_name:literal {
            $( $(#[doc = $field_doc:literal])* pub $field:ident: $type:ty, )+
        }
    ) => {
        $(#[doc = $doc])*
        #[cfg_attr(feature = "services", derive(ZeroCopySend))]
        #[derive(Clone, Copy, Debug, PartialEq, Default,
                 zerocopy::IntoBytes, zerocopy::FromBytes, zerocopy::Immutable, zerocopy::KnownLayout)]
        #[repr(C)]
        pub struct $name {
            $( $(#[doc = $field_doc])* pub $field: $type, )+
        }

        impl $crate::wire::WireMessage for $name {
            const SCHEMA_NAME: &'static str = $schema_name;

            fn fields() -> Vec<$crate::wire::Field> {
                vec![$( $crate::wire::Field {
                    name: stringify!($field),
                    ros_type: <$type as $crate::wire::WireField>::ros_type(),
                    offset: std::mem::offset_of!($name, $field),
                    comment: concat!($($field_doc),*).trim().to_owned(),
                } ),+]
            }

            fn nested_definitions() -> Vec<(&'static str, String)> {
                let mut nested: Vec<(&'static str, String)> = Vec::new();
                $(
                    for definition in <$type as $crate::wire::WireField>::nested_definitions() {
                        if !nested.contains(&definition) {
                            nested.push(definition);
                        }
                    }
                )+
                nested
            }
        }

        impl $crate::wire::WireField for $name {
            fn ros_type() -> String {
                $schema_name.replace("/msg/", "/")
            }
            fn nested_definitions() -> Vec<(&'static str, String)> {
                use $crate::wire::WireMessage as _;
                let mut nested = vec![($schema_name, $crate::wire::field_lines(&Self::fields()))];
                nested.extend(<Self as $crate::wire::WireMessage>::nested_definitions());
                nested
            }
        }
    };
}
