//! Whether memory holds what a picture takes, asked before the work begins.
//!
//! Linux promises more memory than it has, and kills a program that uses too much of it: an allocation alone proves nothing.

/// Whether this process may use so many bytes more, and the machine has them. A system that does not say has them.
pub fn holds(bytes: usize) -> bool {
    let figures = std::fs::read_to_string("/proc/meminfo").ok();
    let left = figures.as_deref().and_then(left);
    may_be_reserved(bytes) && left.is_none_or(|left| bytes as u64 <= left)
}

/// Whether the limits of this process (`ulimit`) leave room for so many bytes.
fn may_be_reserved(bytes: usize) -> bool {
    let mut room = Vec::<u8>::new();
    let is_reserved = room.try_reserve_exact(bytes).is_ok();
    // Otherwise a compiler may leave out what is never used.
    std::hint::black_box(&mut room);
    is_reserved
}

/// Bytes that programs can still use, swap included, from the text of /proc/meminfo.
fn left(figures: &str) -> Option<u64> {
    let bytes = |name: &str| {
        let figure = figures.lines().find_map(|line| line.strip_prefix(name))?;
        let kibibytes: u64 = figure.trim().strip_suffix(" kB")?.parse().ok()?;
        kibibytes.checked_mul(1024)
    };
    bytes("MemAvailable:")?.checked_add(bytes("SwapFree:").unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn available_memory_and_free_swap_are_left() {
        let figures = "MemTotal:  900 kB\nMemFree:  100 kB\nMemAvailable:    300 kB\nSwapTotal: 70 kB\n";
        assert_eq!(left(figures), Some(300 << 10));
        assert_eq!(left(&format!("{figures}SwapFree:       50 kB\n")), Some(350 << 10));
        for unknown in
            ["", "MemFree: 100 kB\n", "MemAvailable: much\n", "MemAvailable: 99999999999999999999 kB\n"]
        {
            assert_eq!(left(unknown), None, "{unknown}");
        }
    }

    #[test]
    fn no_machine_holds_everything() {
        assert!(holds(0) && holds(1 << 20));
        assert!(!holds(usize::MAX) && !holds(usize::MAX / 4));
    }
}
