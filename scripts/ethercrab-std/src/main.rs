//! Cycles with ethercrab's own `std` transport on an interface: `ethercrab-std INTERFACE RATE SECONDS` prints one line, as the
//! example `exchange` does: frames, lost, allocations a frame, p50, p99, p99.9 and longest in µs.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use ethercrab::std::{ethercat_now, tx_rx_task};
use ethercrab::{MainDevice, MainDeviceConfig, PduStorage, RetryBehaviour, Timeouts};

static FRAMES: PduStorage<16, { PduStorage::element_size(1_100) }> = PduStorage::new();

/// The system's allocator, and how often any thread asked it for memory.
struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

// SAFETY: every request goes to the system's allocator as it is.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, interface, rate_hz, seconds] = &arguments[..] else { panic!("give INTERFACE, a rate in Hz and a time in s") };
    let (rate_hz, seconds): (f64, f64) = (rate_hz.parse().unwrap(), seconds.parse().unwrap());
    let (tx, rx, pdu_loop) = FRAMES.try_split().unwrap();
    let timeouts = Timeouts { pdu: Duration::from_millis(100), state_transition: Duration::from_secs(10), ..Timeouts::default() };
    let config = MainDeviceConfig { dc_static_sync_iterations: 0, retry_behaviour: RetryBehaviour::None };
    let main_device = MainDevice::new(pdu_loop, timeouts, config);
    let transport = tx_rx_task(interface, tx, rx).expect("the interface can be opened");
    std::thread::spawn(move || smol::block_on(transport));
    smol::block_on(async {
        let group = main_device.init_single_group::<16, 128>(ethercat_now).await.expect("devices are found");
        let group = group.into_safe_op(&main_device).await.expect("SAFE-OP");
        let period = Duration::from_secs_f64(1.0 / rate_hz);
        let spun = period.mul_f64(0.75).min(Duration::from_micros(150));
        let mut due = Instant::now() + period;
        let mut took = Vec::with_capacity((rate_hz * seconds) as usize);
        let mut lost = 0;
        let before = ALLOCATIONS.load(Ordering::Relaxed);
        while (took.len() as f64) < rate_hz * seconds {
            due = (due + period).max(Instant::now());
            // As the control loop waits: a thread that never sleeps is taken off its core by the kernel.
            std::thread::sleep(due.saturating_duration_since(Instant::now()).saturating_sub(spun));
            while Instant::now() < due {
                std::hint::spin_loop();
            }
            // The same bound as the driver's: a frame that takes longer is lost to its tick.
            let is_back = group.tx_rx(&main_device).await.is_ok() && due.elapsed() < period.mul_f64(0.6);
            lost += u64::from(!is_back);
            took.push(due.elapsed());
        }
        let allocations = (ALLOCATIONS.load(Ordering::Relaxed) - before) as f64 / took.len() as f64;
        took.sort_unstable();
        let at = |share: f64| took[((took.len() - 1) as f64 * share) as usize].as_secs_f64() * 1e6;
        println!("{},{lost},{allocations:.2},{:.1},{:.1},{:.1},{:.1}", took.len(), at(0.5), at(0.99), at(0.999), at(1.0));
    });
}
