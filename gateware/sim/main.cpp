// The simulated device as a program: a host's UART on one side, 32 shift registers on the other, and commands on
// standard input.
//
//     device [DEVICES [CLOCKS [shared]]]
//
// With two devices, the second is switched on CLOCKS after the first and has address 1; its `sync_in` is the `sync` of
// the first, and it has its own line from the host or shares the first one's. Commands for a device:
//
//     d u8            select the device of the next commands, 0 at first
//     b f64           set its host's baud rate
//     u u16, bytes    append to the bytes its host sends
//     e u8            press or release its emergency stop
//     x u32 u32       press it after a number of clocks, for a number of clocks (0: for less than one)
//     t u8            the level of its trigger input
//     r u32           run a number of periods of the first device
//
// At the end of each device's period, a record goes to standard output, all numbers little-endian, and 0xFF after the
// last one of a run:
//
//     u8              the device
//     u8              bit 0: the outputs were on during the whole period; bit 1: at any time in it; bit 2: it follows a
//                     leader; bit 3: its `sync` marks the period; bit 4: its `trigger` is high
//     u64             the clock at the beginning of the period
//     u8 u8 u8 u8     1 if a packet passed the gate, and its type, seq and result
//     u16, bytes      bytes received by the host
//     256 x u8 u8     rise and width, in levels, of the pulse at each register output; 0 0 without a pulse, width 255
//                     for anything but one pulse
//
// A device's first record is of the first period after it has woken up. Commands act between two periods of the first
// device. Memories and registers are random before the reset.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <memory>
#include <vector>

#include "Vwatched.h"
#include "verilated.h"

namespace {

constexpr int LEVELS = 1 << PHASE_BITS;
constexpr int CLOCKS = 8 * (LEVELS < 128 ? 128 : LEVELS);
constexpr int CLOCKS_PER_LEVEL = CLOCKS / LEVELS;
constexpr double CLOCK_HZ = 40000.0 * CLOCKS;

[[noreturn]] void fail(const char *why) {
    std::fprintf(stderr, "simulated device: %s\n", why);
    std::exit(1);
}

// The host's side of the line, at its own bit rate.
class Host {
public:
    void baud(double baud) { bit = CLOCK_HZ / baud; }
    void send(uint8_t byte) { queue.push_back(byte); }

    // The level of the line that the device receives in this clock.
    bool transmit(uint64_t clock) {
        if (left == 0) {
            if (queue.empty()) return true;
            frame = 0x200u | (unsigned(queue.front()) << 1);
            queue.pop_front();
            left = 10;
            edge = std::fmax(edge, double(clock)) + bit;
        }
        const bool level = frame & 1;
        if (double(clock + 1) >= edge) {
            frame >>= 1;
            if (--left > 0) edge += bit;
        }
        return level;
    }

    // The level of the line that the device sends in this clock.
    void receive(uint64_t clock, bool level) {
        if (place < 0) {
            if (level) return;
            place = 0;
            sample = double(clock) + bit / 2;
        }
        if (double(clock) < sample) return;
        sample += bit;
        if (place == 0 && level) {
            place = -1;
        } else if (place == 9) {
            if (level) received.push_back(byte);
            place = -1;
        } else {
            byte = uint8_t(byte >> 1 | level << 7);
            ++place;
        }
    }

    std::vector<uint8_t> received;

private:
    double bit = CLOCK_HZ / 2e6;
    std::deque<uint8_t> queue;
    unsigned frame = 0;
    int left = 0;
    double edge = 0;
    int place = -1;
    double sample = 0;
    uint8_t byte = 0;
};

// 32 shift registers 74x595. Word q holds the bit of Qq of every register.
class Registers {
public:
    using Words = std::array<uint32_t, 8>;

    void shift(uint32_t data) {
        for (int q = 7; q > 0; --q) shifted[q] = shifted[q - 1];
        shifted[0] = data;
    }
    void latch() { outputs = shifted; }

    Words outputs{};

private:
    Words shifted{};
};

// The levels of all outputs during a period.
class Trace {
public:
    void level(int at, const Registers::Words &outputs) { seen[at] = outputs; }

    // 256 pairs of rise and width.
    std::array<uint8_t, 512> pulses() const {
        std::array<uint8_t, 512> pulses{};
        std::array<uint8_t, 256> rises{}, high{};
        for (int t = 0; t < LEVELS; ++t) {
            const auto &now = seen[t], &before = seen[(t + LEVELS - 1) % LEVELS];
            for (int q = 0; q < 8; ++q) {
                each(now[q], q, [&](int n) { ++high[n]; });
                each(now[q] & ~before[q], q, [&](int n) {
                    if (rises[n] < 2) ++rises[n];
                    pulses[2 * n] = uint8_t(t);
                });
            }
        }
        for (int n = 0; n < 256; ++n) {
            const bool constant = rises[n] == 0 && (seen[0][n % 8] >> (n / 8) & 1);
            pulses[2 * n + 1] = rises[n] > 1 || constant ? 255 : high[n];
        }
        return pulses;
    }

private:
    template <typename F> static void each(uint32_t lanes, int q, F &&act) {
        for (; lanes; lanes &= lanes - 1) act(8 * __builtin_ctz(lanes) + q);
    }

    std::array<Registers::Words, LEVELS> seen{};
};

// A device with its surroundings. Clocks are those of the bench.
class Device {
public:
    Device(uint8_t number, uint64_t begins) : number(number), begins(begins) {
        device->rxd = 1;
        device->estop_n = 1;
        device->address = number;
        device->reset = 1;
        device->sync_in = 0;
        device->trigger_in = 0;
    }

    // The first half of a clock. Data latched at its beginning are those from before the shift in its middle.
    void rise(uint64_t clock, bool rxd, bool sync_in) {
        if (clock == begins + 8) device->reset = 0;
        device->rxd = rxd;
        device->sync_in = sync_in;
        device->estop_n = !(pressed || (clock >= press_from && clock < press_to));
        device->clk = 1;
        device->eval();
        if (ended) begin(clock);
        ended = false;
        const bool latched = device->latch && !latch_before;
        latch_before = device->latch;
        if (latched) registers.latch();
        if (device->shift) registers.shift(device->data);
        host.receive(clock, device->txd);
        if (recording) watch(clock, latched);
    }

    // The second half. Returns whether a period ended.
    bool fall(uint64_t clock) {
        device->clk = 0;
        device->eval();
        if (clock == press_from && clock == press_to) {
            device->estop_n = 0;
            device->eval();
            device->estop_n = 1;
            device->eval();
        }
        ended = device->period_ends;
        if (!ended) return false;
        if (recording) write();
        recording = device->awake;
        return recording;
    }

    bool sync() const { return device->sync; }
    bool awake() const { return recording; }
    void emergency(bool is_pressed) { pressed = is_pressed; }
    void trigger(bool level) { device->trigger_in = level; }
    void press(uint64_t from, uint64_t clocks) { press_from = from, press_to = from + clocks; }

    Host host;

private:
    void begin(uint64_t clock) {
        start = clock;
        level = -1;
        always_on = true;
        ever_on = marked = false;
        triggers = device->trigger;
        applied = {};
        if (recording && !device->sync) fail("sync does not rise with a period");
    }

    void watch(uint64_t clock, bool latched) {
        const uint64_t since = clock - start;
        always_on &= !device->oe_n;
        ever_on |= !device->oe_n;
        if (clock >= press_from + 2 && press_from >= start && !device->oe_n) fail("a press leaves the outputs on");
        if (latched) {
            if (++level == LEVELS) fail("a period has too many levels");
            trace.level(level, registers.outputs);
        }
        // A follower's levels may be longer, and its last one missing.
        if (!device->follows && latched != (since % CLOCKS_PER_LEVEL == 0)) fail("a level was not latched at its time");
        if (device->trigger != triggers) fail("trigger changes within a period");
        if (level == 1) marked |= device->sync;
        if (device->sync != (level == 0 || (level == 1 && marked))) fail("sync is not at level 0");
        if (device->applied) {
            if (applied[0]) fail("two packets passed the gate in one period");
            applied = {1, device->applied_type, device->applied_seq, device->applied_result};
        }
    }

    void write() {
        const auto count = uint16_t(host.received.size());
        const auto pulses = trace.pulses();
        std::putchar(number);
        std::putchar(always_on | ever_on << 1 | device->follows << 2 | marked << 3 | triggers << 4);
        for (int i = 0; i < 8; ++i) std::putchar(int(start >> (8 * i) & 0xFF));
        std::fwrite(applied.data(), 1, applied.size(), stdout);
        std::putchar(count & 0xFF);
        std::putchar(count >> 8);
        std::fwrite(host.received.data(), 1, count, stdout);
        std::fwrite(pulses.data(), 1, pulses.size(), stdout);
        host.received.clear();
    }

    std::unique_ptr<Vwatched> device = std::make_unique<Vwatched>();
    uint8_t number;
    uint64_t begins;
    Registers registers;
    Trace trace;
    bool latch_before = false, ended = false, recording = false, pressed = false;
    uint64_t press_from = UINT64_MAX / 2, press_to = 0;
    // Of the current period.
    uint64_t start = 0;
    int level = -1;
    bool always_on = true, ever_on = false, marked = false, triggers = false;
    std::array<uint8_t, 4> applied{};
};

class Bench {
public:
    Bench(unsigned count, uint64_t later, bool shared) : shared(shared) {
        for (unsigned i = 0; i < count; ++i) devices.push_back(std::make_unique<Device>(uint8_t(i), i * later));
        while (!devices[0]->awake()) clock();
    }

    Device &device(unsigned number) {
        if (number >= devices.size()) fail("no such device");
        return *devices[number];
    }
    uint64_t now() const { return clocks; }

    void run(uint32_t periods) {
        while (periods > 0) periods -= clock();
        std::putchar(0xFF);
    }

private:
    // Returns whether the first device's period ended.
    bool clock() {
        const bool sync = devices[0]->sync(), line = devices[0]->host.transmit(clocks);
        for (size_t i = 0; i < devices.size(); ++i) {
            devices[i]->rise(clocks, i == 0 || shared ? line : devices[i]->host.transmit(clocks), i > 0 && sync);
        }
        bool ended = false;
        for (size_t i = 0; i < devices.size(); ++i) {
            const bool one = devices[i]->fall(clocks);
            if (i == 0) ended = one;
        }
        ++clocks;
        return ended;
    }

    std::vector<std::unique_ptr<Device>> devices;
    bool shared;
    uint64_t clocks = 0;
};

template <typename T> T read() {
    T value;
    if (std::fread(&value, sizeof value, 1, stdin) != 1) fail("a command ended early");
    return value;
}

}  // namespace

int main(int count, char **arguments) {
    Verilated::randReset(2);
    const auto number = [&](int at, long otherwise) { return count > at ? std::atol(arguments[at]) : otherwise; };
    Bench bench(unsigned(number(1, 1)), uint64_t(number(2, 0)), count > 3);
    unsigned about = 0;
    for (int command; (command = std::getchar()) != EOF;) {
        Device &device = bench.device(about);
        if (command == 'd') {
            about = read<uint8_t>();
        } else if (command == 'b') {
            const auto baud = read<double>();
            if (!(baud >= 1000 && baud <= CLOCK_HZ / 2)) fail("this baud rate cannot be simulated");
            device.host.baud(baud);
        } else if (command == 'u') {
            for (auto bytes = read<uint16_t>(); bytes > 0; --bytes) device.host.send(read<uint8_t>());
        } else if (command == 'e') {
            device.emergency(read<uint8_t>() != 0);
        } else if (command == 'x') {
            const auto from = read<uint32_t>();
            device.press(bench.now() + from, read<uint32_t>());
        } else if (command == 't') {
            device.trigger(read<uint8_t>() != 0);
        } else if (command == 'r') {
            bench.run(read<uint32_t>());
            if (std::fflush(stdout) != 0) return 0;
        } else {
            fail("unknown command");
        }
    }
}
