//! As much of Chromium's DevTools protocol as a test needs, over pipes: messages of JSON, each with a 0 byte at its end.
//! The browser ends with its pipes.

use serde_json::{Value, json};
use std::ffi::OsString;
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// What a browser is called, the least one first.
const BROWSERS: [&str; 7] = [
    "chromium-headless-shell",
    "google-chrome",
    "google-chrome-stable",
    "chromium",
    "chromium-browser",
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
];

/// The browser to take.
fn browser() -> OsString {
    if let Some(chosen) = std::env::var_os("BOXWOOD_CHROMIUM") {
        return chosen;
    }
    let path = std::env::var_os("PATH").unwrap_or_default();
    // A snap sees another /tmp.
    let folders: Vec<_> =
        std::env::split_paths(&path).filter(|folder| !folder.starts_with("/snap")).collect();
    let places = BROWSERS.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    let found = places.into_iter().find(|place| place.is_file());
    found.map(OsString::from).unwrap_or_else(|| {
        panic!("no Chromium and no Chrome here: `make setup` installs or names one, or set BOXWOOD_CHROMIUM to one")
    })
}

/// A browser without a window, that reaches no network and leaves nothing.
pub struct Browser {
    process: Child,
    to: Option<ChildStdin>,
    from: BufReader<ChildStdout>,
    /// Its profile, and what it said.
    folder: tempfile::TempDir,
    calls: u64,
}

/// A page of it.
pub struct Tab<'b> {
    browser: &'b mut Browser,
    session: Value,
    /// What it was told so far.
    pub events: Vec<Value>,
}

impl Browser {
    /// Starts one.
    pub fn open() -> Self {
        let folder = tempfile::tempdir().unwrap();
        // It listens at file 3 and speaks at file 4, which only a shell can give it without unsafe code.
        let mut command = Command::new("sh");
        command.args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 </dev/null >&2"]).arg(browser());
        command.args([
            "--headless",
            "--remote-debugging-pipe",
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
        ]);
        command.args(["--disable-background-networking", "--host-resolver-rules=MAP * ~NOTFOUND"]);
        command.arg(format!("--user-data-dir={}", folder.path().display())).arg("about:blank");
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        command.stderr(File::create(folder.path().join("said")).unwrap());
        let mut process = command.spawn().unwrap();
        let (to, from) = (process.stdin.take(), BufReader::new(process.stdout.take().unwrap()));
        Self { process, to, from, folder, calls: 0 }
    }

    /// A new page.
    pub fn tab(&mut self) -> Tab<'_> {
        let mut tab = Tab { browser: self, session: Value::Null, events: vec![] };
        let target = tab.call("Target.createTarget", json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        tab.session = tab.call("Target.attachToTarget", attach)["sessionId"].take();
        tab
    }

    fn write(&mut self, message: &Value) {
        let bytes = [message.to_string().as_bytes(), b"\0"].concat();
        self.to.as_mut().unwrap().write_all(&bytes).unwrap();
    }

    fn read(&mut self) -> Value {
        let mut message = vec![];
        self.from.read_until(0, &mut message).unwrap();
        assert_eq!(message.pop(), Some(0), "the browser is gone:\n{}", self.said());
        serde_json::from_slice(&message).unwrap()
    }

    fn said(&self) -> String {
        std::fs::read_to_string(self.folder.path().join("said")).unwrap_or_default()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // It ends once nobody speaks to it, and its profile can go once it has.
        drop(self.to.take());
        let _ = self.process.wait();
    }
}

impl Tab<'_> {
    /// What `method` answers.
    pub fn call(&mut self, method: &str, params: Value) -> Value {
        self.browser.calls += 1;
        let id = self.browser.calls;
        let mut message = json!({ "id": id, "method": method, "params": params });
        if !self.session.is_null() {
            message["sessionId"] = self.session.clone();
        }
        self.browser.write(&message);
        loop {
            let mut answer = self.browser.read();
            if answer["id"] == id {
                assert!(answer["error"].is_null(), "{method}: {answer}");
                return answer["result"].take();
            }
            self.events.push(answer);
        }
    }

    /// Waits for an event.
    pub fn wait(&mut self, event: &str) {
        while !self.events.iter().any(|e| e["method"] == event) {
            let next = self.browser.read();
            self.events.push(next);
        }
    }

    /// The value of an expression of JavaScript.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let asked = json!({ "expression": expression, "returnByValue": true });
        let mut answer = self.call("Runtime.evaluate", asked);
        assert!(answer["exceptionDetails"].is_null(), "{answer}");
        answer["result"]["value"].take()
    }
}
