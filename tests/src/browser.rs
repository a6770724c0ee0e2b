//! A browser without a screen that tests look at the live view with; see `scripts/browser.js`.

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context as _, bail, ensure};
use nix::sys::signal::{Signal, killpg};
use nix::unistd::Pid;
use serde_json::{Value, json};

/// How long something may take to appear: a browser that draws without a graphics card beside a capture is slow, and no
/// test asks how slow.
const PATIENCE: Duration = Duration::from_secs(600);

/// Width and height of a page: small, since a browser without a graphics card pays for each pixel.
pub const SIZE: [u32; 2] = [1100, 700];

/// A running browser; gone when this is dropped.
pub struct Browser {
    driver: Child,
    commands: ChildStdin,
    answers: BufReader<ChildStdout>,
    /// The browser's process group, once a page is open; the driver gives it one of its own.
    group: Option<Pid>,
}

/// A page of it.
#[derive(Clone, Copy, Debug)]
pub struct Page(u64);

/// What a part of a page looks like.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Number of different colours and greys.
    pub shades: u64,
    /// Share of the pixels that are not grey.
    pub coloured: f64,
}

impl Browser {
    /// Starts it.
    ///
    /// # Errors
    /// When none is installed, which `scripts/set-up tests` does.
    pub fn start() -> anyhow::Result<Self> {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts/browser");
        let mut driver = Command::new(script).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let commands = driver.stdin.take().context("the driver has no input")?;
        let answers = BufReader::new(driver.stdout.take().context("the driver has no output")?);
        Ok(Self { driver, commands, answers, group: None })
    }

    /// Opens a page of its own.
    ///
    /// # Errors
    /// When it cannot be opened.
    pub fn open(&mut self, url: &str) -> anyhow::Result<Page> {
        let answer = self.ask(&json!({"open": format!("{url}?renderer=webgl"), "size": SIZE}))?;
        let process = answer["process"].as_i64().context("no process of the browser")?;
        self.group = Some(Pid::from_raw(i32::try_from(process)?));
        Ok(Page(answer["page"].as_u64().context("no number for the page")?))
    }

    /// The value of a JavaScript expression on a page.
    ///
    /// # Errors
    /// When it has none.
    pub fn evaluate(&mut self, page: Page, expression: &str) -> anyhow::Result<Value> {
        Ok(self.ask(&json!({"page": page.0, "evaluate": expression}))?["value"].take())
    }

    /// Waits until an expression is true on a page.
    ///
    /// # Errors
    /// When it never is; a picture of the page is then left among the others.
    pub fn wait_until(&mut self, page: Page, expression: &str) -> anyhow::Result<()> {
        let deadline = Instant::now() + PATIENCE;
        // While a page loads itself again there is nothing to ask.
        while self.evaluate(page, &format!("Boolean({expression})")).ok() != Some(Value::Bool(true)) {
            if Instant::now() > deadline {
                self.picture(page, "never-came")?;
                bail!("never came true: {expression}; the page is pictured in target/screenshots/never-came.png");
            }
            std::thread::sleep(Duration::from_millis(500));
        }
        Ok(())
    }

    /// Clicks on a page.
    ///
    /// # Errors
    /// When the page is gone.
    pub fn click(&mut self, page: Page, x: u32, y: u32) -> anyhow::Result<()> {
        self.ask(&json!({"page": page.0, "click": [x, y]})).map(drop)
    }

    /// Presses the mouse at one place and lets it go at another.
    ///
    /// # Errors
    /// When the page is gone.
    pub fn drag(&mut self, page: Page, from: [u32; 2], to: [u32; 2]) -> anyhow::Result<()> {
        self.ask(&json!({"page": page.0, "drag": [from[0], from[1], to[0], to[1]]})).map(drop)
    }

    /// Takes a picture of a page, `target/screenshots/NAME.png`.
    ///
    /// # Errors
    /// When it cannot be taken.
    pub fn picture(&mut self, page: Page, name: &str) -> anyhow::Result<()> {
        let folder = pictures()?;
        self.ask(&json!({"page": page.0, "picture": folder.join(format!("{name}.png"))})).map(drop)
    }

    /// Looks at a part of a page, given by its left upper corner and its size.
    ///
    /// # Errors
    /// When the page is gone.
    pub fn look(&mut self, page: Page, part: [u32; 4]) -> anyhow::Result<Look> {
        let answer = self.ask(&json!({"page": page.0, "look": part}))?;
        let seen = answer["shades"].as_u64().zip(answer["coloured"].as_f64());
        let (shades, coloured) = seen.context("nothing was seen")?;
        Ok(Look { shades, coloured })
    }

    /// Closes a page.
    ///
    /// # Errors
    /// When it is gone.
    pub fn close(&mut self, page: Page) -> anyhow::Result<()> {
        self.ask(&json!({"page": page.0, "close": true})).map(drop)
    }

    /// Stops the browser with all of its processes where they are, or lets them go on.
    ///
    /// # Errors
    /// When no page was opened yet, or it is gone.
    pub fn signal(&self, signal: Signal) -> anyhow::Result<()> {
        Ok(killpg(self.group.context("no page was opened")?, signal)?)
    }

    fn ask(&mut self, command: &Value) -> anyhow::Result<Value> {
        writeln!(self.commands, "{command}").context("no browser runs; scripts/set-up tests installs one")?;
        let mut line = String::new();
        let length = self.answers.read_line(&mut line)?;
        ensure!(length > 0, "no browser runs; scripts/set-up tests installs one");
        let answer: Value = serde_json::from_str(&line)?;
        ensure!(answer["error"].is_null(), "{command} failed: {}", answer["error"]);
        Ok(answer)
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.signal(Signal::SIGKILL);
        let _ = self.driver.kill();
        let _ = self.driver.wait();
    }
}

/// Where pictures of tests lie: in the target folder that the test itself lies in.
fn pictures() -> anyhow::Result<PathBuf> {
    let own = std::env::current_exe()?;
    let target = own.ancestors().nth(3).context("the test lies in no target folder")?;
    let folder = target.join("screenshots");
    std::fs::create_dir_all(&folder)?;
    Ok(folder)
}
