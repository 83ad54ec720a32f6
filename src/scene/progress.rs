//! Progress bars on stderr. indicatif draws them only on a terminal.

use std::borrow::Cow;
use std::time::Duration;

use super::printable::in_line;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Whether work that takes a while shows bars.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Progress {
    /// On stderr, where that is a terminal.
    #[default]
    Bars,
    /// Never.
    Quiet,
}

impl Progress {
    fn target(self) -> ProgressDrawTarget {
        match self {
            Self::Bars => ProgressDrawTarget::stderr(),
            Self::Quiet => ProgressDrawTarget::hidden(),
        }
    }

    fn styled(
        self,
        length: Option<u64>,
        template: &str,
        message: impl Into<Cow<'static, str>>,
    ) -> ProgressBar {
        let bar = ProgressBar::with_draw_target(length, self.target()).with_message(in_line(message.into()));
        match ProgressStyle::with_template(template) {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        }
    }

    /// A bar over bytes of a file.
    pub(super) fn bytes(self, message: impl Into<Cow<'static, str>>, length: u64) -> ProgressBar {
        self.styled(Some(length), "{msg} {wide_bar} {bytes}/{total_bytes}", message)
    }

    /// A bar over things counted.
    pub(super) fn count(self, message: impl Into<Cow<'static, str>>, length: u64) -> ProgressBar {
        self.styled(Some(length), "{msg} {wide_bar} {human_pos}/{human_len}", message)
    }

    /// For work whose length nobody knows.
    pub(super) fn spinner(self, message: impl Into<Cow<'static, str>>) -> ProgressBar {
        let bar = self.styled(None, "{spinner} {msg} {elapsed}", message);
        bar.enable_steady_tick(Duration::from_millis(120));
        bar
    }
}
