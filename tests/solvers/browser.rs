//! Pages in a real browser: headless Chromium, driven by its DevTools protocol over a pair of pipes.

use crate::run_support::text;
use serde_json::{Value, json};
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Set, it leaves these tests out where there is no Chromium.
const SKIP: &str = "FSI_DRIVER_SKIP_BROWSER";
/// Longest time in which a page must do what it is asked to.
const PATIENCE: Duration = Duration::from_secs(60);

/// A window of a browser that shows a page.
struct Window {
    browser: Child,
    to: File,
    from: BufReader<File>,
    session: Option<String>,
    calls: u64,
    events: Vec<Value>,
    folder: tempfile::TempDir,
}

impl Drop for Window {
    fn drop(&mut self) {
        let _ = self.browser.kill();
        let _ = self.browser.wait();
    }
}

impl Window {
    /// `None` if there is no Chromium and the tests shall be skipped.
    fn open() -> Option<Self> {
        if Command::new("chromium").arg("--version").output().is_err() {
            let skipped = std::env::var_os(SKIP).is_some();
            assert!(
                skipped,
                "there is no chromium: of-adapter/setup.sh --tests installs it, or set {SKIP}=1"
            );
            println!("not tested: there is no chromium, and {SKIP} is set");
            return None;
        }
        let folder = tempfile::tempdir().unwrap();
        let pipes = ["to", "from"].map(|name| folder.path().join(name));
        let made = Command::new("mkfifo").args(&pipes).status().unwrap();
        assert!(made.success());
        // The browser reads commands from descriptor 3 and writes answers to 4.
        let browser = Command::new("sh")
            .arg("-c")
            .arg("exec chromium \"$@\" 3<\"$0/to\" 4>\"$0/from\"")
            .arg(folder.path())
            .args(["--headless", "--no-sandbox", "--hide-scrollbars"])
            .arg("--remote-debugging-pipe")
            .args(["--use-angle=swiftshader", "--enable-unsafe-swiftshader"])
            .arg(format!(
                "--user-data-dir={}",
                folder.path().join("profile").display()
            ))
            .stdout(Stdio::null())
            .stderr(File::create(folder.path().join("messages")).unwrap())
            .spawn()
            .unwrap();
        let to = File::options().write(true).open(&pipes[0]).unwrap();
        let from = BufReader::new(File::open(&pipes[1]).unwrap());
        let mut window = Self {
            browser,
            to,
            from,
            session: None,
            calls: 0,
            events: Vec::new(),
            folder,
        };
        let downloads =
            json!({"behavior": "allow", "downloadPath": window.downloads(), "eventsEnabled": true});
        window.call("Browser.setDownloadBehavior", downloads);
        let target = window.call("Target.createTarget", json!({"url": "about:blank"}));
        let attach = json!({"targetId": target["targetId"], "flatten": true});
        let session = window.call("Target.attachToTarget", attach)["sessionId"].clone();
        window.session = Some(session.as_str().unwrap().to_owned());
        for domain in ["Page", "Runtime", "Log"] {
            window.call(&format!("{domain}.enable"), json!({}));
        }
        Some(window)
    }

    fn downloads(&self) -> PathBuf {
        self.folder.path().join("downloads")
    }

    fn receive(&mut self) -> Value {
        let mut message = Vec::new();
        self.from.read_until(0, &mut message).unwrap();
        if message.pop() != Some(0) {
            let messages = std::fs::read_to_string(self.folder.path().join("messages"));
            panic!("the browser has ended: {}", messages.unwrap_or_default());
        }
        serde_json::from_slice(&message).unwrap()
    }

    fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.calls += 1;
        let mut call = json!({"id": self.calls, "method": method, "params": parameters});
        if let Some(session) = &self.session {
            call["sessionId"] = json!(session);
        }
        self.to.write_all(format!("{call}\0").as_bytes()).unwrap();
        loop {
            let mut answer = self.receive();
            if answer["id"] == self.calls {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].take();
            }
            self.events.push(answer);
        }
    }

    /// Loads a page in a window of this width.
    fn load(&mut self, page: &Path, width: u32) {
        self.resize(width);
        self.events.clear();
        let url = format!("file://{}", page.display());
        self.call("Page.navigate", json!({ "url": url }));
        while !self
            .events
            .iter()
            .any(|event| event["method"] == "Page.loadEventFired")
        {
            let event = self.receive();
            self.events.push(event);
        }
    }

    fn resize(&mut self, width: u32) {
        let size = json!({"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": false});
        self.call("Emulation.setDeviceMetricsOverride", size);
    }

    /// The value of an expression of JavaScript in the page.
    fn value(&mut self, expression: &str) -> Value {
        let what = json!({"expression": expression, "returnByValue": true, "userGesture": true});
        let mut answer = self.call("Runtime.evaluate", what);
        let failed = &answer["exceptionDetails"];
        assert!(failed.is_null(), "{expression}: {failed}");
        answer["result"]["value"].take()
    }

    /// Waits until an expression is true.
    fn until(&mut self, expression: &str) {
        let start = Instant::now();
        while self.value(expression) != json!(true) {
            assert!(start.elapsed() < PATIENCE, "never: {expression}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    fn mouse(&mut self, kind: &str, [x, y]: [f64; 2]) {
        let event =
            json!({"type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1});
        self.call("Input.dispatchMouseEvent", event);
    }

    /// What the page has complained about: exceptions, errors and warnings.
    fn complaints(&self) -> Vec<&Value> {
        let complains = |event: &&Value| match event["method"].as_str() {
            Some("Runtime.exceptionThrown") => true,
            Some("Runtime.consoleAPICalled") => {
                ["error", "warning"].contains(&event["params"]["type"].as_str().unwrap())
            }
            Some("Log.entryAdded") => {
                let entry = &event["params"]["entry"];
                // The software renderer of a machine without graphics says that reading its pixels is slow.
                ["error", "warning"].contains(&entry["level"].as_str().unwrap())
                    && !entry["text"].as_str().unwrap().contains("ReadPixels")
            }
            _ => false,
        };
        self.events.iter().filter(complains).collect()
    }
}

/// Pixels of the three-dimensional view that are not background, and a sum over all.
const VIEW: &str = "(() => {
    const view = document.querySelector('.viewer canvas'), copy = document.createElement('canvas');
    [copy.width, copy.height] = [view.width, view.height];
    const context = copy.getContext('2d');
    context.drawImage(view, 0, 0);
    const pixels = context.getImageData(0, 0, copy.width, copy.height).data;
    let drawn = 0, sum = 0;
    for (let i = 0; i < pixels.length; i += 4) {
        drawn += Math.min(pixels[i], pixels[i + 1], pixels[i + 2]) < 240;
        sum = (31 * sum + 65536 * pixels[i] + 256 * pixels[i + 1] + pixels[i + 2]) % 4294967291;
    }
    return [drawn, sum];
})()";

/// Figures, drawings or pictures in them, that show nothing.
const EMPTY_FIGURES: &str = "[...document.querySelectorAll('figure')].filter((figure) => {
    const drawing = figure.querySelector('svg'), picture = figure.querySelector('img');
    if (picture) return !(picture.complete && picture.naturalWidth > 0);
    const box = drawing.getBoundingClientRect();
    const drawn = drawing.querySelectorAll('path, polyline, image, rect, circle').length;
    return !(box.width > 50 && box.height > 50 && drawn > 3 && drawing.getBBox().width > 50);
}).map((figure) => figure.textContent)";

/// What reaches beyond the right edge of the window, but for tables that scroll in a frame of their own.
const TOO_WIDE: &str = "[...document.querySelectorAll('body *')].filter((element) =>
    !element.closest('.table') && !element.closest('svg') &&
    element.getBoundingClientRect().right > document.documentElement.clientWidth + 1
).map((element) => element.outerHTML.slice(0, 200))";

/// Loads the page wide and narrow: no complaint, every figure drawn, nothing wider than the window.
fn is_whole(window: &mut Window, page: &Path) {
    for width in [1280, 400] {
        window.load(page, width);
        assert_eq!(window.value(EMPTY_FIGURES), json!([]), "{}", page.display());
        assert_eq!(window.value("document.documentElement.scrollWidth"), width);
        assert_eq!(window.value(TOO_WIDE), json!([]), "{}", page.display());
        if window.value("document.querySelector('.viewer') !== null") == json!(true) {
            window.until(&format!("{VIEW}[0] > 2000"));
        }
        assert!(window.complaints().is_empty(), "{:?}", window.complaints());
    }
}

/// A page of a run shows all of its figures, its view rotates and plays, and its numbers can be saved.
#[test]
fn the_page_of_a_run_works_in_a_browser() {
    let Some(mut window) = Window::open() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let fsi = |words: &[&str], paths: &[&Path]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
        let output = command.args(words).args(paths).output().unwrap();
        assert!(output.status.success(), "{}", text(&output));
    };
    let vessel = root.join("openfoam-case/S-0.25");
    let short = "--preset demo --fluid native --end-time 0.05 --quiet --set output.structure_interval_s=0.01 --out";
    let words: Vec<&str> = short.split(' ').collect();
    let case = [&["--case", vessel.to_str().unwrap()], &words[..]].concat();
    fsi(&case, &[&run]);
    fsi(&["report"], &[&run]);
    let page = run.join("report.html");
    // One file to send, of a size that a mail takes.
    let size = std::fs::metadata(&page).unwrap().len();
    assert!((500_000..2_500_000).contains(&size), "{size}");

    is_whole(&mut window, &page);
    window.load(&page, 1280);
    let figures = window.value("document.querySelectorAll('figure').length");
    assert!(figures.as_u64().unwrap() > 12, "{figures}");
    window.until(&format!("{VIEW}[0] > 2000"));

    // It rotates.
    let place = "(() => {
        const canvas = document.querySelector('.viewer canvas');
        canvas.scrollIntoView({block: 'center', behavior: 'instant'});
        const box = canvas.getBoundingClientRect();
        return [box.x + box.width / 2, box.y + box.height / 2];
    })()";
    let [x, y]: [f64; 2] = serde_json::from_value(window.value(place)).unwrap();
    let before = window.value(VIEW);
    window.mouse("mousePressed", [x, y]);
    for i in 1..=10 {
        window.mouse("mouseMoved", [x + 8.0 * f64::from(i), y]);
    }
    window.mouse("mouseReleased", [x + 80.0, y]);
    window.until(&format!("{VIEW}[1] !== {}", before[1]));

    // It plays, stops, and shows other fields.
    let time = "document.querySelector('.viewer output').textContent";
    let click = "document.querySelector('.viewer button').click()";
    let shown = window.value(time);
    assert!(shown.as_str().unwrap().starts_with("t = 0.0"), "{shown}");
    window.value(click);
    window.until(&format!("{time} !== {shown}"));
    window.value(click);
    let stopped = window.value(VIEW);
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(window.value(VIEW), stopped);
    let choose = "(() => {
        const choice = document.querySelector('.viewer select');
        choice.selectedIndex = 1;
        choice.dispatchEvent(new Event('change'));
        return choice.length;
    })()";
    assert!(window.value(choose).as_u64().unwrap() > 3);
    window.until(&format!("{VIEW}[1] !== {}", stopped[1]));

    // Its numbers can be saved, as they are in the page.
    let links = "[...document.querySelectorAll('a.download')].map((link) => [link.download, atob(link.href.split(',')[1])])";
    let links: Vec<[String; 2]> = serde_json::from_value(window.value(links)).unwrap();
    assert!(links.len() > 6, "{}", links.len());
    for (i, [name, bytes]) in links.iter().enumerate() {
        window.value(&format!(
            "document.querySelectorAll('a.download')[{i}].click()"
        ));
        let expected: Vec<u8> = bytes.chars().map(|c| c as u8).collect();
        let start = Instant::now();
        while std::fs::read(window.downloads().join(name)).ok().as_ref() != Some(&expected) {
            assert!(start.elapsed() < PATIENCE, "{name} was not saved whole");
            std::thread::sleep(Duration::from_millis(50));
        }
        // The browser refuses more than ten downloads at once.
        std::thread::sleep(Duration::from_millis(250));
    }
    assert!(window.complaints().is_empty(), "{:?}", window.complaints());

    // So do the pages of a study and of a vessel before anything is computed.
    fsi(&["report"], &[folder.path()]);
    is_whole(&mut window, &folder.path().join("report.html"));
    let preview = folder.path().join("vessel");
    let aneurysm = root.join("examples/vessels/aneurysm");
    fsi(
        &["preview", aneurysm.to_str().unwrap(), "--out"],
        &[&preview],
    );
    is_whole(&mut window, &preview.join("preview.html"));
}
