//! Whether the colours of the figures can be told apart, also by those who do not see all of them.

use std::array::from_fn;

const FIGURE: &str = include_str!("../../src/figure.css");
const PAGE: &str = include_str!("../../src/report.html");

/// Red, green and blue, linear.
type Rgb = [f64; 3];

/// What is seen: by most, and with protanopia, deuteranopia and tritanopia (Machado, Oliveira and Fernandes, 2009:
/// severity 1.0, on linear RGB).
const EYES: [[Rgb; 3]; 4] = [
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
];

/// Least distance of two colours in `OKLab`: some five times what is just seen (0.02).
const APART: f64 = 0.095;

/// Least contrast of a mark with what is behind it (WCAG 2.1, 1.4.11).
const CONTRAST: f64 = 3.0;

fn linear(hex: &str) -> Rgb {
    from_fn(|k| {
        let level = u8::from_str_radix(&hex[2 * k..2 * k + 2], 16).unwrap();
        let level = f64::from(level) / 255.0;
        match level <= 0.04045 {
            true => level / 12.92,
            false => ((level + 0.055) / 1.055).powf(2.4),
        }
    })
}

fn product(matrix: &[Rgb; 3], x: Rgb) -> Rgb {
    from_fn(|i| (0..3).map(|j| matrix[i][j] * x[j]).sum())
}

/// Lightness and two opponent colours (Ottosson, 2020).
fn oklab(colour: Rgb) -> Rgb {
    const CONES: [Rgb; 3] = [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ];
    const OPPONENTS: [Rgb; 3] = [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ];
    product(&OPPONENTS, product(&CONES, colour).map(f64::cbrt))
}

fn contrast(a: Rgb, b: Rgb) -> f64 {
    let luminance = |c: Rgb| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2] + 0.05;
    let (a, b) = (luminance(a), luminance(b));
    a.max(b) / a.min(b)
}

/// The values of a variable in a style sheet, in their order.
fn values<'a>(style: &'a str, name: &str) -> Vec<&'a str> {
    let sets = format!("--{name}:#");
    style
        .match_indices(&sets)
        .map(|(at, _)| {
            let rest = &style[at + sets.len()..];
            &rest[..rest.find([';', '}']).unwrap()]
        })
        .collect()
}

#[test]
fn colours_can_be_told_apart() {
    let named = |letter: char| (0..6).map(move |k| format!("{letter}{k}"));
    for (theme, name) in ["light", "dark"].iter().enumerate() {
        // Figures of the page are light by their own style, and dark by that of the page.
        let figure = |variable: &str| match theme {
            0 => values(FIGURE, variable)[0],
            _ => values(PAGE, variable)[0],
        };
        let mut colours: Vec<&str> = named('c').map(|variable| figure(&variable)).collect();
        let legend: Vec<&str> = named('k')
            .map(|variable| values(PAGE, &variable)[theme])
            .collect();
        assert_eq!(
            colours, legend,
            "{name}: the legend has the colours of the figures"
        );
        for behind in ["page", "soft"] {
            let behind = match values(PAGE, behind)[theme] {
                "fff" => "ffffff",
                six => six,
            };
            for colour in &colours {
                let contrast = contrast(linear(colour), linear(behind));
                assert!(
                    contrast >= CONTRAST,
                    "{name}: #{colour} on #{behind}: {contrast:.2}"
                );
            }
        }
        colours.push(figure("noise"));
        for eyes in &EYES {
            let seen =
                |colour: &&str| oklab(product(eyes, linear(colour)).map(|x| x.clamp(0.0, 1.0)));
            let seen: Vec<Rgb> = colours.iter().map(seen).collect();
            for (i, a) in seen.iter().enumerate() {
                for (j, b) in seen[..i].iter().enumerate() {
                    let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
                    let apart = squares.sqrt();
                    assert!(
                        apart >= APART,
                        "{name}: #{} and #{}: {apart:.3}",
                        colours[i],
                        colours[j]
                    );
                }
            }
        }
    }
}
