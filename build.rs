//! Tells the library how it was built, for `rigid.build_info()`.

use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=.git/logs/HEAD");
    println!("cargo:rerun-if-changed=src");
    println!("cargo:rerun-if-env-changed=RIGID_COMMIT");
    println!("cargo::rustc-check-cfg=cfg(plain)");
    let is_x86_64 = std::env::var("CARGO_CFG_TARGET_ARCH").is_ok_and(|arch| arch == "x86_64");
    if std::env::var_os("CARGO_FEATURE_PLAIN").is_some() || !is_x86_64 {
        println!("cargo::rustc-cfg=plain");
    }
    let commit = std::env::var("RIGID_COMMIT").ok().or_else(|| {
        // Not the commit of a repository that we merely lie in.
        std::path::Path::new(".git").exists().then_some(())?;
        let output =
            Command::new("git").args(["describe", "--always", "--dirty", "--abbrev=12"]).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_string())
    });
    println!("cargo:rustc-env=RIGID_COMMIT={}", commit.unwrap_or_default());
    let profile = std::env::var("PROFILE").expect("cargo sets it");
    println!("cargo:rustc-env=RIGID_PROFILE={profile}");
}
