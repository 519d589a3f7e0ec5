//! Orbit diagrams that several machines compute: shares, their journals, and the diagram that comes of them.

use crate::common::{Folder, begin, chatter, fails, interrupt, succeeds, told, typed, wait_for};

/// Small enough for a test, with pieces of several rows.
fn small<'a>(sweep: &'a str, rest: &[&'a str]) -> Vec<&'a str> {
    let asked =
        "diagram pressure_relief_valve --section closing --observe y2 --transient 40 --keep 10";
    let mut arguments = typed(asked, &["--sweep", sweep]);
    arguments.extend(rest);
    arguments
}

const SWEEP: &str = "q=0.0201:0.0225:50";

#[test]
fn shares_come_to_the_file_of_one_machine() {
    let folder = Folder::new("shares");
    let (whole, parts) = (folder.file("whole.npz"), folder.file("parts.npz"));
    for start in [
        &["--start", "carry", "--chunk", "4"][..],
        &["--start", "carry:both", "--chunk", "7"],
        &["--start", "random:3", "--box", "y3=9.8:10.2", "--exponent"],
        &[],
    ] {
        let ask = |rest: &[&str], out: &str| {
            let mut arguments = small(SWEEP, start);
            arguments.extend(rest.iter().chain(&["--out", out]));
            succeeds(&arguments)
        };
        ask(&[], &whole);
        let mut journals = Vec::new();
        // More shares than there are pieces leave some of them empty.
        let count = 9;
        for number in 1..=count {
            let share = format!("{number}/{count}");
            let said = ask(&["--shard", &share], &parts);
            assert!(
                said.contains(&format!("share {number} of {count} is done")),
                "{said}"
            );
            // Asked for again it has nothing to do.
            let journal = folder.file(&format!("parts.{number}-of-{count}.journal"));
            let before = std::fs::read(&journal).unwrap();
            ask(&["--shard", &share], &parts);
            assert!(std::fs::read(&journal).unwrap() == before);
            journals.push(journal);
        }
        assert!(!folder.names().contains(&"parts.npz".to_owned()));
        // In another order, and one left out, which is computed then.
        journals.rotate_left(4);
        journals.remove(2);
        let mut merge = vec!["merge"];
        merge.extend(journals.iter().map(String::as_str));
        merge.extend(["--out", &parts]);
        let said = succeeds(&merge);
        assert!(said.contains("wrote"), "{said}");
        assert!(
            folder.bytes("whole.npz") == folder.bytes("parts.npz"),
            "{start:?}"
        );
        assert!(!folder.names().contains(&"parts.npz.journal".to_owned()));
        for name in folder.names() {
            std::fs::remove_file(folder.path(&name)).unwrap();
        }
    }
}

#[test]
fn a_share_that_was_killed_goes_on_or_is_merged_as_far_as_it_is() {
    let folder = Folder::new("killed-share");
    let (whole, parts) = (folder.file("whole.npz"), folder.file("parts.npz"));
    fn asked<'a>(rest: &[&'a str]) -> Vec<&'a str> {
        let mut arguments = small("q=0.0201:0.0225:400", &["--start", "carry", "--chunk", "8"]);
        arguments.extend(rest);
        arguments
    }
    let mut first = asked(&["--threads", "1", "--shard", "1/2"]);
    first.extend(["--out", &parts]);
    let journal = folder.file("parts.1-of-2.journal");
    let mut child = begin(&first);
    wait_for(&journal, 6_000);
    child.kill().unwrap();
    child.wait().unwrap();
    let twice = fails(&["merge", &journal, &journal, "--out", &parts]);
    assert!(twice.contains("is given twice"), "{twice}");
    let merge = ["merge", &journal, "--out", &parts];
    succeeds(&merge);
    let mut one = asked(&[]);
    one.extend(["--out", &whole]);
    succeeds(&one);
    assert!(folder.bytes("whole.npz") == folder.bytes("parts.npz"));
    let said = chatter(&first);
    assert_eq!(said.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&said.stderr).contains("going on from"));
}

#[test]
fn branches_from_several_orbits_are_shared_merged_and_gone_on_with() {
    let folder = Folder::new("shared-branches");
    let (whole, parts, killed) = (
        folder.file("whole.npz"),
        folder.file("parts.npz"),
        folder.file("killed.npz"),
    );
    let line = "continue impact_oscillator --set omega=2.6 --sweep omega=2.4:3.2 --step 0.004 --all 3 --starts 40 --out";
    let asked = |out: &str, rest: &[&str]| {
        let mut arguments = typed(line, &[out]);
        arguments.extend(rest);
        arguments
            .into_iter()
            .map(str::to_owned)
            .collect::<Vec<String>>()
    };
    let ask = |arguments: &[String]| {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        succeeds(&arguments)
    };
    let said = ask(&asked(&whole, &[]));
    // Two of the orbits there lie on one branch, which is followed once.
    let orbits = "orbit impact_oscillator --set omega=2.6 --all 3 --starts 40";
    let orbits = succeeds(&typed(orbits, &[]));
    let count = |text: &str, word: &str| text.lines().filter(|l| l.starts_with(word)).count();
    let (orbits, branches) = (count(&orbits, "  period "), count(&said, "branch "));
    assert!(
        (2..orbits).contains(&branches),
        "{branches} branches of {orbits} orbits"
    );
    let mut journals = Vec::new();
    for number in 1..=4 {
        let share = asked(&parts, &["--shard", &format!("{number}/4")]);
        let said = ask(&share);
        assert!(
            said.contains(&format!("share {number} of 4 is done")),
            "{said}"
        );
        let journal = folder.file(&format!("parts.{number}-of-4.journal"));
        let before = std::fs::read(&journal).unwrap();
        ask(&share);
        assert!(std::fs::read(&journal).unwrap() == before);
        journals.push(journal);
    }
    // In another order, and one left out, which is followed then.
    journals.rotate_left(2);
    journals.pop();
    let mut merge = vec!["merge"];
    merge.extend(journals.iter().map(String::as_str));
    merge.extend(["--out", &parts]);
    assert!(succeeds(&merge).contains("branch 1"));
    assert!(folder.bytes("whole.npz") == folder.bytes("parts.npz"));
    // Others are refused.
    let other = typed(
        "continue impact_oscillator --set omega=2.6 --sweep omega=2.4:3.1 --all 3 --starts 40 --shard 1/40 --out",
        &[&killed],
    );
    succeeds(&other);
    let foreign = folder.file("killed.01-of-40.journal");
    let said = fails(&["merge", &journals[0], &foreign, "--out", &killed]);
    assert!(
        said.contains("other branches") && said.contains("another sweep"),
        "{said}"
    );
    // Killed and gone on with.
    let arguments = asked(&killed, &[]);
    let mut child = begin(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
    wait_for(&format!("{killed}.journal"), 30_000);
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!std::fs::exists(&killed).unwrap());
    // And stopped: what is done by then is written.
    let known = std::fs::metadata(format!("{killed}.journal"))
        .unwrap()
        .len();
    let child = begin(&["continue", "--resume", &killed]);
    wait_for(&format!("{killed}.journal"), known + 30_000);
    told(&interrupt(child), 130, &killed);
    succeeds(&["continue", "--resume", &killed]);
    assert!(folder.bytes("whole.npz") == folder.bytes("killed.npz"));
    assert!(!folder.names().contains(&"killed.npz.journal".to_owned()));
    let wrong = "continue impact_oscillator --sweep omega=2.4:3 --shard 1/2 --out";
    assert!(fails(&typed(wrong, &[&killed])).contains("--all"));
}

#[test]
fn foreign_journals_and_wrong_shares_are_refused() {
    let folder = Folder::new("foreign-share");
    let (a, b) = (folder.file("a.npz"), folder.file("b.npz"));
    succeeds(&small(SWEEP, &["--shard", "1/30", "--out", &a]));
    succeeds(&small(
        "q=0.0201:0.0225:51",
        &["--shard", "2/30", "--out", &b],
    ));
    let (one, other) = (
        folder.file("a.01-of-30.journal"),
        folder.file("b.02-of-30.journal"),
    );
    let said = fails(&["diagram", "--resume", &a]);
    assert!(
        said.contains(&one) && said.contains("chatter merge"),
        "{said}"
    );
    let said = fails(&["merge", &one, &other, "--out", &a]);
    assert!(
        said.contains("another diagram") && said.contains("another sweep"),
        "{said}"
    );
    let said = fails(&["merge", &folder.file("none.journal"), "--out", &a]);
    assert!(said.contains("there is no file"), "{said}");
    folder.write("text.journal", "something else");
    let said = fails(&["merge", &folder.file("text.journal"), "--out", &a]);
    assert!(said.contains("journal"), "{said}");
    for share in ["0/3", "4/3", "x"] {
        assert!(fails(&small(SWEEP, &["--shard", share, "--out", &a])).contains("NUMBER/COUNT"));
    }
    assert!(fails(&small(SWEEP, &["--shard", "1/3"])).contains("--out"));
    // A share of few pieces is told to be one.
    let said = chatter(&small(SWEEP, &["--shard", "1/2", "--out", &a]));
    assert!(
        String::from_utf8_lossy(&said.stderr).contains("pieces that can be computed side by side")
    );
}
