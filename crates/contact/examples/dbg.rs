use signorini_contact::*;
fn main() {
    let p = match problem_file::read(std::env::args().nth(1).unwrap()).unwrap() {
        problem_file::ProblemFile::Contact(p) => p,
        _ => panic!(),
    };
    let s = ContactSolver::default().solve(&p, None);
    let sv = p.velocity_scale();
    let g = p.delassus_scale();
    println!("sv {sv:e} g {g:e} status {:?} cert {:?}", s.status, s.certificate);
    let mut scratch = vec![0.0; p.nv()];
    for i in 0..p.contact_count() {
        let mut c = p.contact_velocity(i, &s.velocity);
        c[0] += p.gap[i] / p.timestep;
        let l = s.impulse[i];
        let d = p.delassus_diagonal(i, &mut scratch);
        println!(
            "{i:3} {:?} lam*g/sv [{:+.3e} {:+.3e} {:+.3e}] gauge {:+.3e} u/sv [{:+.2e} {:+.2e} {:+.2e}] beta {:.1e} phi {:.1e} diag {:.1} {:.1} {:.1}",
            s.modes[i],
            l[0] * g / sv,
            l[1] * g / sv,
            l[2] * g / sv,
            (s.alpha[p.direction_offsets[i]..p.direction_offsets[i + 1]].iter().sum::<f64>()
                / (p.friction[i] * l[0].max(1e-300))),
            c[0] / sv,
            c[1] / sv,
            c[2] / sv,
            s.beta[i] / sv,
            p.gap[i],
            d[0],
            d[1],
            d[2]
        );
    }
}
