use super::*;
use crate::measure::file;

const SIZE: (u32, u32) = (900, 540);

fn axis(label: &str, scale: Scale) -> Axis {
    Axis { label: label.into(), scale }
}

fn point(x: f64, y: f64) -> Point {
    Point { x, y, low: y, high: y }
}

/// A single named series: its markers are circles.
fn plot(points: &[(f64, f64)], scale: Scale) -> Plot {
    let points = points.iter().map(|&(x, y)| point(x, y)).collect();
    let series = Series { name: "forward".into(), points, line: true, marked: Vec::new() };
    let (x, y) = (axis("lights", Scale::Log), axis("frame (ms)", scale));
    Plot { title: "Frame time".into(), caption: String::new(), x, y, series: vec![series] }
}

fn bars(values: &[&[Option<f64>]], stacked: bool) -> Bars {
    let series = values.iter().enumerate().map(|(i, values)| (format!("pass {i}"), values.to_vec())).collect();
    let groups = (0..values.first().map_or(0, |v| v.len())).map(|i| format!("clustered-forward {i}")).collect();
    Bars { title: "Passes".into(), groups, series, stacked, y: axis("ms", Scale::Linear), caption: String::new() }
}

fn svg(figure: Figure) -> String {
    let text = figure.svg(SIZE).expect("an SVG");
    assert_eq!(fault(&text), None, "{text}");
    assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
    text
}

/// What keeps a text from being well-formed XML of the kind that plotters writes.
fn fault(text: &str) -> Option<String> {
    let mut open = Vec::new();
    for part in text.split('<').skip(1) {
        let Some((tag, content)) = part.split_once('>') else { return Some(format!("no end: {part}")) };
        let entities = ["&amp;", "&lt;", "&gt;", "&quot;", "&apos;"];
        if entities.iter().fold(part.to_string(), |rest, entity| rest.replace(entity, "")).contains('&') {
            return Some(format!("a bare ampersand: {part}"));
        }
        if tag.matches('"').count() % 2 == 1 || part.chars().any(|c| c.is_control() && c != '\n') {
            return Some(format!("a bad character: {part}"));
        }
        if let Some(name) = tag.strip_prefix('/') {
            if open.pop() != Some(name) {
                return Some(format!("closed but not open: {name}"));
            }
        } else if !tag.ends_with('/') {
            open.push(tag.split(' ').next().unwrap_or_default());
        }
        if open.is_empty() && !content.trim().is_empty() {
            return Some(format!("text outside: {content}"));
        }
    }
    open.pop().map(|name| format!("not closed: {name}"))
}

/// Numbers of attributes of every `tag`.
fn numbers<const N: usize>(svg: &str, tag: &str, attributes: [&str; N]) -> Vec<[f64; N]> {
    let tags = svg.split('<').filter(|part| part.split(' ').next() == Some(tag));
    let number = |part: &str, name: &str| {
        let after = part.split(&format!(" {name}=\"")).nth(1).and_then(|rest| rest.split('"').next());
        after.and_then(|text| text.parse().ok()).unwrap_or_else(|| panic!("{name} of {part}"))
    };
    tags.map(|part| attributes.map(|name| number(part, name))).collect()
}

fn circles(svg: &str) -> Vec<[f64; 2]> {
    numbers(svg, "circle", ["cx", "cy"])
}

#[test]
fn faults_are_found() {
    for text in ["<a><b></a>", "<a", "<a>&</a>", "<a b=\"></a>", "<a/>b", "<a>", "<a>\u{1}</a>"] {
        assert!(fault(text).is_some(), "{text}");
    }
    assert_eq!(fault("<a b=\"1\">\n<c/>&amp;</a>\n"), None);
}

#[test]
fn a_png_has_its_size_and_notes() {
    let notes = [("lampyris".to_string(), "lampyris bench lights".to_string())];
    let png = Figure::Plot(plot(&[(1.0, 2.0), (10.0, 3.0)], Scale::Linear)).png((500, 310), &notes).expect("a PNG");
    let image = image::load_from_memory(&png).expect("a picture");
    assert_eq!((image.width(), image.height()), (500, 310));
    assert_eq!(file::png_text(&png), notes);
}

#[test]
fn both_forms_show_the_same_picture() {
    let figure = Figure::Plot(plot(&[(1.0, 2.0), (10.0, 3.0), (1000.0, 40.0)], Scale::Log));
    let png = figure.png(SIZE, &[]).expect("a PNG");
    let image = image::load_from_memory(&png).expect("a picture").to_rgb8();
    let text = svg(figure);
    assert!(text.starts_with("<svg width=\"900\" height=\"540\" viewBox=\"0 0 2700 1620\" "), "{text}");
    let places = circles(&text);
    assert_eq!(places.len(), 4, "three points and the legend's mark");
    let color = marks::colour(0);
    for [x, y] in places {
        let pixel = image.get_pixel((x / 3.0) as u32, (y / 3.0) as u32);
        assert_eq!(pixel.0, [color.0, color.1, color.2], "at {x}, {y}");
        // The control: above a marker there is none of its colour.
        assert_ne!(image.get_pixel((x / 3.0) as u32, (y / 3.0) as u32 - 9).0, pixel.0);
    }
    let dark = |x: u32, y: u32| image.get_pixel(x, y).0.iter().all(|&c| c < 100);
    assert!((0..900).any(|x| (10..36).any(|y| dark(x, y))), "the title is drawn");
}

#[test]
fn the_legend_is_beside_the_data() {
    let text = svg(Figure::Plot(plot(&[(1.0, 1.0), (1e6, 9.0)], Scale::Linear)));
    let places = circles(&text);
    // The legend is drawn first.
    let reach = f64::from(FINE) * 9.0;
    assert!(places[1..].iter().all(|place| place[0] + reach < places[0][0] - reach), "{places:?}");
    assert!(text.contains("forward"));
}

#[test]
fn values_without_a_place_are_counted() {
    let values = [(1.0, 0.0), (2.0, 5.0), (3.0, -1.0), (4.0, f64::NAN), (5.0, f64::INFINITY), (0.0, 5.0), (7.0, 6.0)];
    let text = svg(Figure::Plot(plot(&values, Scale::Log)));
    assert!(text.contains("5 values not shown"), "{text}");
    assert_eq!(circles(&text).len(), 3, "two points and the legend's mark");
    let text = svg(Figure::Plot(plot(&values[..3], Scale::Linear)));
    assert!(!text.contains("not shown"), "{text}");
    let text = svg(Figure::Plot(plot(&values[..2], Scale::Log)));
    assert!(text.contains("1 value not shown"), "{text}");
}

#[test]
fn spreads_reach_to_their_ends() {
    let with = |low: f64, high: f64| {
        let mut plot = plot(&[(1.0, 5.0)], Scale::Log);
        plot.series[0].points[0] = Point { x: 1.0, y: 5.0, low, high };
        svg(Figure::Plot(plot))
    };
    let paths = |text: &str| text.matches("stroke=\"#0072B2\"").count();
    let none = paths(&with(5.0, 5.0));
    assert_eq!(paths(&with(4.0, 7.0)), none + 3);
    assert_eq!(paths(&with(0.0, 5.0)), none + 3, "below the axis");
    assert_eq!(paths(&with(f64::NAN, f64::NAN)), none);
}

#[test]
fn an_empty_figure_says_so() {
    let figures = [Figure::Plot(Plot::default()), Figure::Plot(plot(&[], Scale::Log)), Figure::Bars(Bars::default())];
    for figure in figures {
        assert!(figure.png(SIZE, &[]).is_ok());
        let text = svg(figure);
        assert!(text.contains("nothing measured") && text.contains("<line"), "{text}");
    }
    assert!(!svg(Figure::Plot(plot(&[(1.0, 1.0)], Scale::Linear))).contains("nothing measured"));
}

#[test]
fn marked_points_stand_out() {
    let mut plot = plot(&[(1.0, 1.0), (2.0, 2.0)], Scale::Linear);
    plot.series[0].marked = vec![true, false];
    let text = svg(Figure::Plot(plot));
    // Ring, its gap and the marker; a hollow marker's two; the legend's one.
    assert_eq!(circles(&text).len(), 3 + 2 + 1);
}

#[test]
fn missing_bars_are_gaps() {
    let text = svg(Figure::Bars(bars(&[&[Some(1.0), None], &[Some(2.0), Some(3.0)]], false)));
    assert_eq!(text.matches("n/a").count(), 1);
    let rectangles = numbers(&text, "rect", ["width", "height"]);
    assert_eq!(rectangles.len(), 1 + 2 + 3, "the paper, two marks of the legend, three bars");
    assert!((rectangles[4][1] - 2.0 * rectangles[3][1]).abs() <= 3.0, "heights are values: {rectangles:?}");
}

#[test]
fn stacked_bars_stand_on_one_another() {
    let text = svg(Figure::Bars(bars(&[&[Some(1.0)], &[Some(2.0)], &[None]], true)));
    let rectangles = numbers(&text, "rect", ["y", "height"]);
    let [first, second] = [rectangles[4], rectangles[5]];
    assert_eq!(second[0] + second[1], first[0]);
    assert!(text.contains("+ n/a"), "a part is missing");
}

#[test]
fn hostile_words_stay_words() {
    let mut plot = plot(&[(1.0, 1.0)], Scale::Linear);
    plot.title = "<b> & \"\u{0}\u{ffff}' ".to_string() + &"long ".repeat(500);
    plot.caption = "x".repeat(5000);
    plot.x.label = "</text><script>".into();
    plot.series =
        (0..60).map(|i| Series { name: format!("{i} <&> {}", "w".repeat(90)), ..Series::default() }).collect();
    let figure = Figure::Plot(plot);
    assert!(figure.png((480, 300), &[]).is_ok());
    let text = svg(figure);
    assert!(text.contains("&lt;b&gt; &amp;") && text.contains("…") && !text.contains("<script"), "{text}");
    assert!(text.contains(" more"), "series that have no room in the legend are counted");
}

#[test]
fn sizes_out_of_range_are_refused() {
    for size in [(10, 540), (900, 10), (100_000, 540)] {
        let error = Figure::Plot(Plot::default()).svg(size).expect_err("refused").to_string();
        assert!(error.contains(&format!("{}x{}", size.0, size.1)), "{error}");
        assert!(Figure::Plot(Plot::default()).png(size, &[]).is_err());
    }
}
