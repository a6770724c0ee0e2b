//! Where each field lies in a message, read from the `ros2msg` schema that the file carries.
//!
//! Archives describe themselves: a reader that looks fields up by name opens captures of other
//! versions too. Offsets follow plain CDR (OMG DDS-XTypes 1.3, 7.4.3): a primitive of `n` bytes
//! lies at a multiple of `n`, counted from the end of the four-byte header; structs and fixed
//! arrays have no alignment of their own.
//!
//! ```
//! use archive::schema::Layout;
//!
//! let layout = Layout::parse("uint8 flags\nfloat64[2] pair  # both\npkg/Inner inner\n\
//!     ====\nMSG: pkg/Inner\nuint32 count\n").unwrap();
//! assert_eq!(layout.field("pair").unwrap().offset, 8);
//! assert_eq!(layout.field("inner.count").unwrap().offset, 24);
//! assert_eq!(layout.size, Some(28));
//! ```

use std::collections::HashMap;

/// A type of `ros2msg` with a fixed size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the variants are the names of the primitive types")]
pub enum Primitive {
    Bool,
    Int8,
    Uint8,
    Int16,
    Uint16,
    Int32,
    Uint32,
    Int64,
    Uint64,
    Float32,
    Float64,
}

/// A field, or an element of a nested one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FieldLayout {
    /// Name; `outer.inner` for a field of a nested struct, `outer[2].inner` in an array of structs.
    pub name: String,
    /// Type of the field or of its elements.
    pub primitive: Primitive,
    /// Elements; 1 for a scalar.
    pub count: usize,
    /// Bytes from the end of the CDR header.
    pub offset: usize,
}

/// The fields of a message and where they lie.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    /// The fields in the order of their bytes, up to the first one of variable size.
    pub fields: Vec<FieldLayout>,
    /// Bytes of the body without the CDR header; `None` when a field has a variable size.
    pub size: Option<usize>,
}

/// Why a schema is not understood.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SchemaError {
    /// A line is neither a field, a constant nor a comment.
    #[error("line {line} (`{text}`) is not a field")]
    NotAField {
        /// Line, counted from 1 in its definition.
        line: usize,
        /// The line.
        text: String,
    },
    /// A type is used and not defined.
    #[error("the type `{name}` is not defined in it")]
    UnknownType {
        /// The type.
        name: String,
    },
    /// Types contain each other, or an array is absurdly long.
    #[error("it has more than {MAX_FIELDS} fields, nests deeper than {MAX_DEPTH} levels or is longer than 64 KiB")]
    TooLarge,
}

/// More fields than any message of an instrument has.
const MAX_FIELDS: usize = 4096;
/// More lines, counted each time that an array repeats them, than any message of an instrument has.
const MAX_LINES: usize = 65_536;
/// More bytes than any schema of an instrument has. The names of all fields together may have 16 times as many: a name counts again
/// in every element of an array.
const MAX_BYTES: usize = 65_536;
/// Deeper than any message of an instrument nests.
const MAX_DEPTH: usize = 16;

impl Primitive {
    fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "bool" => Self::Bool,
            "int8" => Self::Int8,
            "uint8" | "byte" | "char" => Self::Uint8,
            "int16" => Self::Int16,
            "uint16" => Self::Uint16,
            "int32" => Self::Int32,
            "uint32" => Self::Uint32,
            "int64" => Self::Int64,
            "uint64" => Self::Uint64,
            "float32" => Self::Float32,
            "float64" => Self::Float64,
            _ => return None,
        })
    }

    /// Size and alignment, bytes.
    #[must_use]
    pub const fn size(self) -> usize {
        match self {
            Self::Bool | Self::Int8 | Self::Uint8 => 1,
            Self::Int16 | Self::Uint16 => 2,
            Self::Int32 | Self::Uint32 | Self::Float32 => 4,
            Self::Int64 | Self::Uint64 | Self::Float64 => 8,
        }
    }
}

impl FieldLayout {
    /// The field's (first) value as a real number; `None` when the body is too short.
    ///
    /// `body` begins after the CDR header and is little-endian.
    #[must_use]
    pub fn as_f64(&self, body: &[u8]) -> Option<f64> {
        let bytes = body.get(self.offset..)?;
        Some(match self.primitive {
            Primitive::Float64 => f64::from_le_bytes(first(bytes)?),
            Primitive::Float32 => f64::from(f32::from_le_bytes(first(bytes)?)),
            Primitive::Int64 => i64::from_le_bytes(first(bytes)?) as f64,
            Primitive::Int32 => f64::from(i32::from_le_bytes(first(bytes)?)),
            Primitive::Int16 => f64::from(i16::from_le_bytes(first(bytes)?)),
            Primitive::Int8 => f64::from(i8::from_le_bytes(first(bytes)?)),
            _ => self.as_u64(body)? as f64,
        })
    }

    /// The field's value as an unsigned integer, the first of an array; `None` when the body is too short or the type is
    /// not an unsigned integer.
    #[must_use]
    pub fn as_u64(&self, body: &[u8]) -> Option<u64> {
        let bytes = body.get(self.offset..)?;
        Some(match self.primitive {
            Primitive::Uint64 => u64::from_le_bytes(first(bytes)?),
            Primitive::Uint32 => u64::from(u32::from_le_bytes(first(bytes)?)),
            Primitive::Uint16 => u64::from(u16::from_le_bytes(first(bytes)?)),
            Primitive::Uint8 | Primitive::Bool => u64::from(*bytes.first()?),
            _ => return None,
        })
    }
}

fn first<const N: usize>(bytes: &[u8]) -> Option<[u8; N]> {
    bytes.first_chunk().copied()
}

impl Layout {
    /// Reads a `ros2msg` schema: the message's fields, then the definitions of the types it uses.
    ///
    /// # Errors
    /// [`SchemaError`] when a line or a type is not understood.
    pub fn parse(text: &str) -> Result<Self, SchemaError> {
        if text.len() > MAX_BYTES {
            return Err(SchemaError::TooLarge);
        }
        let mut definitions = text.split_inclusive('\n').fold(vec![String::new()], |mut sections, line| {
            let rule = line.trim_end();
            if rule.len() >= 3 && rule.bytes().all(|byte| byte == b'=') {
                sections.push(String::new());
            } else if let Some(section) = sections.last_mut() {
                section.push_str(line);
            }
            sections
        });
        let nested: HashMap<String, String> = definitions
            .split_off(1)
            .into_iter()
            .filter_map(|section| {
                let (title, body) = section.split_once('\n')?;
                let name = title.trim().strip_prefix("MSG:")?.trim().replace("/msg/", "/");
                Some((name, body.to_owned()))
            })
            .collect();
        let mut placing =
            Placing { nested: &nested, fields: Vec::new(), end: 0, variable: false, lines: 0, name_bytes: 0 };
        placing.message(&definitions[0], "", "", 0)?;
        let Placing { fields, end, variable, .. } = placing;
        Ok(Self { fields, size: (!variable).then_some(end) })
    }

    /// The field of that name.
    #[must_use]
    pub fn field(&self, name: &str) -> Option<&FieldLayout> {
        self.fields.iter().find(|field| field.name == name)
    }

    /// The names of all fields, for a message to a person.
    #[must_use]
    pub fn field_names(&self) -> String {
        self.fields.iter().map(|field| field.name.as_str()).collect::<Vec<_>>().join(", ")
    }
}

/// Places fields one after the other.
struct Placing<'a> {
    nested: &'a HashMap<String, String>,
    fields: Vec<FieldLayout>,
    end: usize,
    /// A field of variable size was met: nothing behind it has a fixed place.
    variable: bool,
    /// Messages and lines placed so far, repetitions included: even an array of a message without fields can take endless time.
    lines: usize,
    /// Length of all names so far.
    name_bytes: usize,
}

impl Placing<'_> {
    fn message(&mut self, definition: &str, prefix: &str, package: &str, depth: usize) -> Result<(), SchemaError> {
        self.count_line()?;
        for (index, raw) in definition.lines().enumerate() {
            if self.variable {
                return Ok(());
            }
            self.count_line()?;
            let line = raw.split('#').next().unwrap_or_default().trim();
            if line.is_empty() {
                continue;
            }
            let Some((type_name, rest)) = line.split_once(char::is_whitespace) else {
                return Err(SchemaError::NotAField { line: index + 1, text: line.to_owned() });
            };
            // A bound stands in the type and a default value behind a space: `string<=8 name "a=b"` is a field.
            let rest = rest.trim_start();
            let end = rest.find(|letter: char| letter.is_whitespace() || letter == '=').unwrap_or(rest.len());
            let (name, value) = rest.split_at(end);
            if !value.trim_start().starts_with('=') {
                self.field(type_name, &format!("{prefix}{name}"), package, depth)?;
            }
        }
        Ok(())
    }

    fn field(&mut self, type_name: &str, name: &str, package: &str, depth: usize) -> Result<(), SchemaError> {
        self.name_bytes += name.len();
        if depth > MAX_DEPTH || self.fields.len() > MAX_FIELDS || self.name_bytes > 16 * MAX_BYTES {
            return Err(SchemaError::TooLarge);
        }
        let (element, count) = match type_name.split_once('[') {
            None => (type_name, Some(1)),
            Some((element, bound)) => (element, bound.trim_end_matches(']').parse::<usize>().ok()),
        };
        let Some(count) = count.filter(|_| !element.starts_with("string") && !element.starts_with("wstring")) else {
            self.variable = true;
            return Ok(());
        };
        if let Some(primitive) = Primitive::from_name(element) {
            let offset = self.end.next_multiple_of(primitive.size());
            let bytes = primitive.size().checked_mul(count).ok_or(SchemaError::TooLarge)?;
            self.end = offset.checked_add(bytes).ok_or(SchemaError::TooLarge)?;
            self.fields.push(FieldLayout { name: name.to_owned(), primitive, count, offset });
            return Ok(());
        }
        let nested = self.nested;
        let full_name = element.replace("/msg/", "/");
        let local_name = format!("{package}/{full_name}");
        let (owner, definition) = [&full_name, &local_name]
            .into_iter()
            .find_map(|candidate| nested.get_key_value(candidate))
            .or_else(|| nested.iter().find(|(known, _)| known.rsplit('/').next() == Some(full_name.as_str())))
            .ok_or_else(|| SchemaError::UnknownType { name: element.to_owned() })?;
        let package = owner.split('/').next().unwrap_or_default();
        let is_array = type_name.contains('[');
        for index in 0..count {
            let prefix = if is_array { format!("{name}[{index}].") } else { format!("{name}.") };
            self.message(definition, &prefix, package, depth + 1)?;
            if self.variable || self.fields.len() > MAX_FIELDS {
                break;
            }
        }
        if self.fields.len() > MAX_FIELDS { Err(SchemaError::TooLarge) } else { Ok(()) }
    }

    /// Counts a message or a line of one.
    fn count_line(&mut self) -> Result<(), SchemaError> {
        self.lines += 1;
        if self.lines > MAX_LINES { Err(SchemaError::TooLarge) } else { Ok(()) }
    }
}
