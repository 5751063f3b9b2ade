//! The system's allocator with a count of the bytes that each thread holds, so that a test can bound the memory of a call
//! whatever other threads do.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    /// Bytes that this thread has taken and not given back, and the most that this was since [`peak_of`] began. Negative
    /// where it gave back what other threads took.
    static HELD: Cell<(isize, isize)> = const { Cell::new((0, 0)) };
}

struct Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn count(change: isize) {
    // A thread that is ending may have no cell any more; nothing is measured there.
    let _ = HELD.try_with(|held| {
        let (now, peak) = held.get();
        let now = now.wrapping_add(change);
        held.set((now, peak.max(now)));
    });
}

// SAFETY: every call goes on to `System` unchanged. Counting neither allocates nor unwinds: the cell is constant-initialised
// and has no destructor.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller promises what `System` asks for.
        let place = unsafe { System.alloc(layout) };
        if !place.is_null() {
            count(layout.size() as isize);
        }
        place
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        let place = unsafe { System.alloc_zeroed(layout) };
        if !place.is_null() {
            count(layout.size() as isize);
        }
        place
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: as above; `place` came from `System`, which every allocation here goes to.
        unsafe { System.dealloc(place, layout) };
        count(-(layout.size() as isize));
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as in `dealloc`.
        let moved = unsafe { System.realloc(place, layout, size) };
        if !moved.is_null() {
            count((size as isize).wrapping_sub(layout.size() as isize));
        }
        moved
    }
}

/// What `call` returns, and the most heap bytes that this thread held during it beyond those it held before.
pub fn peak_of<T>(call: impl FnOnce() -> T) -> (T, usize) {
    let before = HELD.with(|held| {
        let now = held.get().0;
        held.set((now, now));
        now
    });
    let result = call();
    let peak = HELD.with(|held| held.get().1);
    (result, peak.wrapping_sub(before) as usize)
}

#[test]
fn the_peak_is_this_threads_own() {
    const MIB: usize = 1 << 20;
    let (_, peak) = peak_of(|| {
        drop(std::hint::black_box(vec![1u8; 3 * MIB]));
        let mut grown = std::hint::black_box(vec![1u8; MIB]);
        grown.reserve_exact(MIB);
        std::hint::black_box(grown).len()
    });
    assert_eq!(peak, 3 * MIB);
    let (_, peak) = peak_of(|| {
        std::thread::scope(|scope| {
            scope.spawn(|| std::hint::black_box(vec![1u8; 8 * MIB]).len());
        });
    });
    assert!(peak < MIB, "another thread's 8 MiB are counted here: {peak} bytes");
}
