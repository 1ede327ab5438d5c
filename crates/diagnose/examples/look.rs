use trueaxis_diagnose::{Settings, diagnose};
fn main() {
    for path in std::env::args().skip(1) {
        let campaign = trueaxis_campaign::read(std::path::Path::new(&path)).unwrap();
        let t = std::time::Instant::now();
        match diagnose(&campaign, &Settings::default()) {
            Err(e) => println!("{path}: {e}"),
            Ok(d) => {
                println!("{path}: {} {:?}", d.verdict.name(), t.elapsed());
                for l in &d.levels {
                    println!(
                        "  floor {:.3} before {:?} after {:?} gain {:?}",
                        l.noise_floor_um, l.before, l.after, l.gain
                    );
                    for t in &l.tests {
                        println!("   {} {} p={:.3e}", t.varies_with, t.columns, t.p_value);
                    }
                    for t in &l.tests_after {
                        println!(
                            "   after {} {} p={:.3e}",
                            t.varies_with, t.columns, t.p_value
                        );
                    }
                }
                for c in &d.causes {
                    println!(
                        "  {} {:?} p={:.1e} bic={:.1} {:?}",
                        c.effect.effect.id(),
                        c.effect.subject,
                        c.p_value,
                        c.delta_bic,
                        c.parameters
                    );
                    for r in &c.rivals {
                        println!(
                            "    or {} {:?} {:.1}",
                            r.effect.effect.id(),
                            r.effect.subject,
                            r.delta_bic
                        );
                    }
                }
                println!("  {:?}", d.unexplained);
            }
        }
    }
}
