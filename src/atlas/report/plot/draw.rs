//! A canvas as SVG text or PNG bytes, through the backends of `plotters`.
//!
//! The backends take whole pixels. Therefore an SVG is drawn ten times as large and scaled down by its view
//! box. A PNG is drawn four times as large, and squares of two by two pixels are averaged, which also smooths
//! edges. If a picture has very many shapes, its SVG contains an image with the texts above it, so that the
//! size of the file does not grow with the number of points. The same canvas gives the same bytes.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use plotters::prelude::{BitMapBackend, DrawingBackend, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{
    FontDesc, FontFamily, FontStyle, FontTransform, RGBColor, ShapeStyle, TextStyle,
};

use super::canvas::{Anchor, Canvas, Colour, Place, Shape};
use super::error::PlotError;
use super::lettering::{FAMILY, LINE_PER_EM, font_is_ready};

/// Size of a font for the SVG backend, per em: the backend divides the size by this number.
const SVG_SIZE_PER_EM: f64 = 1.24;
/// Units of the SVG view box per pixel.
const SVG_SCALE: f64 = 10.0;
/// Pixels of a PNG per pixel of the canvas.
pub(super) const PNG_SCALE: usize = 2;
/// Distance to which shapes may extend beyond the picture \[px\].
const OVERHANG: f64 = 100.0;
/// Largest number of shapes that an SVG document contains as shapes: these take 2 MB.
const MOST_SHAPES: usize = 20_000;
/// Number of drawn pixels per pixel of a PNG, in both directions.
const OVERSAMPLING: usize = 2;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Medium {
    Svg,
    Bitmap,
}

/// The canvas as an SVG document.
///
/// # Errors
/// The backend fails.
pub(super) fn svg(canvas: &Canvas) -> Result<String, PlotError> {
    let [width, height] = canvas.size().map(|length| (length * SVG_SCALE) as u32);
    let pressed = canvas.shapes.len() > MOST_SHAPES;
    let mut text = String::new();
    {
        let mut backend = SVGBackend::with_string(&mut text, (width, height));
        let shown = |shape: &Shape| !pressed || is_text(shape);
        draw(canvas, shown, &mut backend, SVG_SCALE, Medium::Svg)?;
    }
    if pressed {
        let image = STANDARD.encode(image(canvas, |shape| !is_text(shape))?);
        let image = format!(
            "<image width=\"{width}\" height=\"{height}\" href=\"data:image/png;base64,{image}\"/>\n"
        );
        // Insert the image above the background, which is the first shape, and below the texts.
        let place = text.find("<text").unwrap_or(text.len());
        text.insert_str(place, &image);
    }
    let drawn = format!("width=\"{width}\" height=\"{height}\"");
    let shown = format!(
        "width=\"{}\" height=\"{}\"",
        canvas.size()[0],
        canvas.size()[1]
    );
    Ok(text.replacen(&drawn, &shown, 1))
}

/// The canvas as a PNG file.
///
/// # Errors
/// The backend or the encoder fails.
pub(super) fn png(canvas: &Canvas) -> Result<Vec<u8>, PlotError> {
    image(canvas, |_| true)
}

fn is_text(shape: &Shape) -> bool {
    matches!(shape, Shape::Text { .. })
}

/// The `shown` shapes of a canvas, as a PNG file.
fn image(canvas: &Canvas, shown: impl Fn(&Shape) -> bool) -> Result<Vec<u8>, PlotError> {
    let scale = PNG_SCALE * OVERSAMPLING;
    let [width, height] = canvas.size().map(|length| length as usize * scale);
    let mut pixels = vec![0; 3 * width * height];
    {
        let size = (width as u32, height as u32);
        let mut backend = BitMapBackend::with_buffer(&mut pixels, size);
        draw(canvas, shown, &mut backend, scale as f64, Medium::Bitmap)?;
    }
    let averaged = average(&pixels, width);
    let mut bytes = Vec::new();
    let size = [width, height].map(|length| (length / OVERSAMPLING) as u32);
    let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Best);
    // Colours are flat: filters, which suit photographs, make files a fifth larger here.
    encoder.set_filter(png::FilterType::NoFilter);
    let mut writer = encoder.write_header().map_err(PlotError::drawing)?;
    writer
        .write_image_data(&averaged)
        .map_err(PlotError::drawing)?;
    writer.finish().map_err(PlotError::drawing)?;
    Ok(bytes)
}

/// Averages squares of `OVERSAMPLING` pixels of an RGB image.
fn average(pixels: &[u8], width: usize) -> Vec<u8> {
    let rows = pixels.chunks_exact(3 * width * OVERSAMPLING);
    let mut averaged = Vec::with_capacity(pixels.len() / (OVERSAMPLING * OVERSAMPLING));
    for row in rows {
        for column in 0..width / OVERSAMPLING {
            for channel in 0..3 {
                let mut sum = 0;
                for y in 0..OVERSAMPLING {
                    for x in 0..OVERSAMPLING {
                        let pixel = y * width + column * OVERSAMPLING + x;
                        sum += usize::from(row[3 * pixel + channel]);
                    }
                }
                averaged.push((sum / (OVERSAMPLING * OVERSAMPLING)) as u8);
            }
        }
    }
    averaged
}

fn draw<B: DrawingBackend>(
    canvas: &Canvas,
    shown: impl Fn(&Shape) -> bool,
    backend: &mut B,
    scale: f64,
    medium: Medium,
) -> Result<(), PlotError> {
    if !font_is_ready() {
        return Err(PlotError::drawing("the built-in font cannot be read"));
    }
    // The bitmap backend visits every pixel of a shape, even beyond the picture. Clamp the coordinates to
    // limit the time.
    let size = canvas.size();
    let near =
        |place: f64, size: f64| (place.clamp(-OVERHANG, size + OVERHANG) * scale).round() as i32;
    let whole = |place: Place| (near(place[0], size[0]), near(place[1], size[1]));
    let white = RGBColor(255, 255, 255);
    backend
        .draw_rect((0, 0), whole(canvas.size()), &white, true)
        .map_err(PlotError::drawing)?;
    for shape in canvas.shapes.iter().filter(|shape| shown(shape)) {
        match shape {
            Shape::Line {
                points,
                colour,
                width,
            } => {
                let style = stroke(*colour, width * scale);
                let places: Vec<(i32, i32)> = points.iter().copied().map(whole).collect();
                match medium {
                    Medium::Svg => backend.draw_path(places, &style),
                    // The backend fills a thick path as one polygon, which is wrong if the path crosses
                    // itself. Draw separate lines with round joints instead.
                    Medium::Bitmap => {
                        let pairs = places.windows(2).filter(|pair| pair[0] != pair[1]);
                        pairs
                            .map(|pair| (pair[0], pair[1]))
                            .try_for_each(|(from, to)| {
                                backend.draw_path([from, to], &style)?;
                                let radius = style.stroke_width / 2;
                                backend.draw_circle(to, radius, &style.filled(), true)
                            })
                    }
                }
            }
            Shape::Rectangle { from, to, colour } => {
                backend.draw_rect(whole(*from), whole(*to), &rgb(*colour), true)
            }
            Shape::Polygon { points, colour } => {
                backend.fill_polygon(points.iter().copied().map(whole), &rgb(*colour))
            }
            Shape::Disc {
                centre,
                radius,
                colour,
            } => {
                let radius = (radius * scale).round() as u32;
                backend.draw_circle(whole(*centre), radius, &rgb(*colour), true)
            }
            Shape::Text {
                at,
                text,
                size,
                colour,
                anchor,
                upwards,
            } => {
                let em = size * scale;
                // Size of the text for the backend, and distance from the top of the text to its baseline.
                let (size, drop) = match medium {
                    Medium::Svg => (em * SVG_SIZE_PER_EM, 0.76 * em),
                    Medium::Bitmap => (em * LINE_PER_EM, 0.5 * em * LINE_PER_EM),
                };
                let (x, y) = whole(*at);
                let drop = drop.round() as i32;
                let (place, turn) = if *upwards {
                    ((x - drop, y), FontTransform::Rotate270)
                } else {
                    ((x, y - drop), FontTransform::None)
                };
                let font = FontDesc::new(FontFamily::Name(FAMILY), size, FontStyle::Normal)
                    .transform(turn);
                let across = match anchor {
                    Anchor::Start => HPos::Left,
                    Anchor::Middle => HPos::Center,
                    Anchor::End => HPos::Right,
                };
                let ink = rgb(*colour);
                let style = TextStyle::from(font)
                    .color(&ink)
                    .pos(Pos::new(across, VPos::Top));
                backend.draw_text(text, &style, place)
            }
        }
        .map_err(PlotError::drawing)?;
    }
    backend.present().map_err(PlotError::drawing)
}

fn rgb(colour: Colour) -> RGBColor {
    RGBColor(colour.0, colour.1, colour.2)
}

fn stroke(colour: Colour, width: f64) -> ShapeStyle {
    ShapeStyle::from(&rgb(colour)).stroke_width(width.round().max(1.0) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::plot::canvas::{BLUE, INK};

    fn pixels(canvas: &Canvas) -> (usize, Vec<u8>) {
        let bytes = png(canvas).unwrap();
        let mut reader = png::Decoder::new(bytes.as_slice()).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size()];
        let frame = reader.next_frame(&mut pixels).unwrap();
        (frame.width as usize, pixels)
    }

    #[test]
    fn a_rectangle_covers_its_pixels_and_no_others() {
        let mut canvas = Canvas::titled("", "");
        canvas.rectangle([100.0, 200.0], [110.0, 220.0], BLUE);
        let (width, pixels) = pixels(&canvas);
        let at = |x: usize, y: usize| &pixels[3 * (y * width + x)..][..3];
        assert_eq!(at(201, 401), [BLUE.0, BLUE.1, BLUE.2]);
        assert_eq!(at(218, 438), [BLUE.0, BLUE.1, BLUE.2]);
        for outside in [(198, 420), (222, 420), (210, 398), (210, 442)] {
            assert_eq!(at(outside.0, outside.1), [255; 3], "{outside:?}");
        }
    }

    #[test]
    fn a_path_that_crosses_itself_is_drawn_whole() {
        let corners = [
            [100.0, 100.0],
            [200.0, 200.0],
            [200.0, 100.0],
            [100.0, 200.0],
        ];
        let mut canvas = Canvas::titled("", "");
        canvas.line(&corners, INK, 2.0);
        let (width, pixels) = pixels(&canvas);
        for [x, y] in [[150, 150], [120, 120], [200, 150], [120, 180]] {
            let pixel = &pixels[3 * (2 * y * width + 2 * x)..][..3];
            assert!(pixel[0] < 0x80, "nothing at {x}, {y}: {pixel:?}");
        }
    }

    #[test]
    fn markup_in_names_is_escaped() {
        let canvas = Canvas::titled("a<b> & \"c\"", "");
        let document = svg(&canvas).unwrap();
        let document = roxmltree::Document::parse(&document).unwrap();
        let text = document.descendants().find(|n| n.has_tag_name("text"));
        assert_eq!(text.unwrap().text().unwrap().trim(), "a<b> & \"c\"");
    }

    /// A mark on every second pixel, and a text: once with few shapes, once with very many.
    #[test]
    fn very_many_shapes_are_an_image_below_the_texts() {
        let of = |side: usize| {
            let mut canvas = Canvas::titled("a title", "");
            for place in 0..side * side {
                let [x, y] = [place % side, place / side].map(|i| 100.0 + 2.0 * i as f64);
                canvas.rectangle([x, y], [x + 1.0, y + 1.0], BLUE);
            }
            svg(&canvas).unwrap()
        };
        let (few, many) = (of(20), of(220));
        let count = |text: &str, tag: &str| {
            let document = roxmltree::Document::parse(text).unwrap();
            document
                .descendants()
                .filter(|node| node.has_tag_name(tag))
                .count()
        };
        assert_eq!((count(&few, "image"), count(&few, "rect")), (0, 401));
        assert_eq!((count(&many, "image"), count(&many, "rect")), (1, 1));
        assert!(many.len() < 200_000, "{} bytes", many.len());
        assert!(many.find("<image") < many.find("<text"));
        let base64 = many
            .split("base64,")
            .nth(1)
            .unwrap()
            .split('"')
            .next()
            .unwrap();
        let bytes = STANDARD.decode(base64).unwrap();
        let mut reader = png::Decoder::new(bytes.as_slice()).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size()];
        let width = reader.next_frame(&mut pixels).unwrap().width as usize;
        let at = |x: usize, y: usize| pixels[3 * (y * width + x)];
        assert_eq!(
            [at(200, 200), at(202, 200)],
            [BLUE.0, 255],
            "a mark and none"
        );
    }
}
