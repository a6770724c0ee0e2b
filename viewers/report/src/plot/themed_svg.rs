//! A plotters backend that writes compact SVG with classes in place of colours.
//!
//! plotters works in whole pixels. A pixel here is a tenth of an SVG unit, fine enough for print.

use std::convert::Infallible;
use std::fmt::Write as _;

use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind, FontTransform,
};

use crate::plot::ink::Ink;

/// plotters pixels per SVG unit.
pub(crate) const PIXELS_PER_UNIT: u32 = 10;

/// Dots in one path. A path is painted at once, so its dots do not darken each other; those of the next path do.
const DOTS_PER_PATH: usize = 400;

type Done = Result<(), DrawingErrorKind<Infallible>>;

/// Writes the marks of a plot, without the `svg` element around them.
pub(crate) struct ThemedSvg<'a> {
    marks: &'a mut String,
    size: (u32, u32),
    dots: Vec<BackendCoord>,
    dot_ink: Ink,
}

impl<'a> ThemedSvg<'a> {
    /// A backend of `size` pixels that appends to `marks`.
    pub(crate) fn new(marks: &'a mut String, size: (u32, u32)) -> Self {
        Self { marks, size, dots: Vec::new(), dot_ink: Ink::Measured }
    }

    fn flush_dots(&mut self) {
        if self.dots.is_empty() {
            return;
        }
        let _ = write!(self.marks, r#"<path class="dots {}" d=""#, self.dot_ink.class());
        for (x, y) in self.dots.drain(..) {
            self.marks.push('M');
            push_coordinate(self.marks, x);
            self.marks.push(' ');
            push_coordinate(self.marks, y);
            self.marks.push_str("h0");
        }
        self.marks.push_str("\"/>");
    }

    fn path(&mut self, kind: &str, ink: Ink, points: impl IntoIterator<Item = BackendCoord>, end: &str) {
        self.flush_dots();
        let _ = write!(self.marks, r#"<path class="{kind} {}" d="M"#, ink.class());
        let mut previous = None;
        for (x, y) in points {
            if previous == Some((x, y)) {
                continue;
            }
            if previous.is_some() {
                self.marks.push(' ');
            }
            push_coordinate(self.marks, x);
            self.marks.push(' ');
            push_coordinate(self.marks, y);
            previous = Some((x, y));
        }
        let _ = write!(self.marks, "{end}\"/>");
    }
}

fn push_coordinate(text: &mut String, pixels: i32) {
    let sign = if pixels < 0 { "-" } else { "" };
    let (whole, tenth) = (pixels.unsigned_abs() / PIXELS_PER_UNIT, pixels.unsigned_abs() % PIXELS_PER_UNIT);
    let _ = if tenth == 0 { write!(text, "{sign}{whole}") } else { write!(text, "{sign}{whole}.{tenth}") };
}

impl DrawingBackend for ThemedSvg<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Done {
        Ok(())
    }

    fn present(&mut self) -> Done {
        self.flush_dots();
        Ok(())
    }

    fn draw_pixel(&mut self, point: BackendCoord, color: BackendColor) -> Done {
        self.draw_circle(point, 1, &color, true)
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Done {
        self.draw_path([from, to], style)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Done {
        if style.color().alpha > 0.0 {
            self.path("line", Ink::of(style.color()), path, "");
        }
        Ok(())
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        (left, top): BackendCoord,
        (right, bottom): BackendCoord,
        style: &S,
        _fill: bool,
    ) -> Done {
        self.fill_polygon([(left, top), (right, top), (right, bottom), (left, bottom)], style)
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, corners: I, style: &S) -> Done {
        self.path("area", Ink::of(style.color()), corners, "Z");
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(&mut self, center: BackendCoord, _radius: u32, style: &S, _fill: bool) -> Done {
        let ink = Ink::of(style.color());
        if ink != self.dot_ink || self.dots.len() == DOTS_PER_PATH {
            self.flush_dots();
            self.dot_ink = ink;
        }
        self.dots.push(center);
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, (x, y): BackendCoord) -> Done {
        self.flush_dots();
        let anchor = match style.anchor().h_pos {
            HPos::Left => "start",
            HPos::Center => "middle",
            HPos::Right => "end",
        };
        // Shares of the font size from the anchor to the baseline.
        let drop = match style.anchor().v_pos {
            VPos::Top => "0.76em",
            VPos::Center => "0.35em",
            VPos::Bottom => "-0.24em",
        };
        let angle = match style.transform() {
            FontTransform::None => None,
            FontTransform::Rotate90 => Some(90),
            FontTransform::Rotate180 => Some(180),
            FontTransform::Rotate270 => Some(270),
        };
        let (mut across, mut down) = (String::new(), String::new());
        push_coordinate(&mut across, x);
        push_coordinate(&mut down, y);
        let rotation =
            angle.map_or_else(String::new, |angle| format!(r#" transform="rotate({angle} {across} {down})""#));
        let class = Ink::of(style.color()).class();
        let text = maud::html! { (text) }.into_string();
        let _ = write!(
            self.marks,
            r#"<text class="{class}" x="{across}" y="{down}" dy="{drop}" text-anchor="{anchor}"{rotation}>{text}</text>"#
        );
        Ok(())
    }
}
