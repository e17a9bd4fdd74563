// The device as a program: a host's UART on its one side, 32 shift registers on its other, and commands on standard input.
//
//     b f64           the host's baud
//     u u16, bytes    append to what the host sends
//     e u8            the emergency stop is pressed, or not
//     r u32           run so many periods
//
// For each period a record goes to standard output, all numbers little-endian:
//
//     u8              1 if the outputs were on during the whole period
//     u8 u8 u8 u8     1 if a packet went through the gate, and its type, seq and result
//     u16, bytes      what the host received
//     256 x u8 u8     rise and width, in levels, of the pulse at each register output; 0 0 without one, 255 as width if what was seen
//                     is not one pulse
//
// Period 0 begins with the first level that the device latches as its own. Commands act between two periods.
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

// What stood at the outputs at each level of a period.
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

class Bench {
public:
    Bench() {
        device->rxd = 1;
        device->estop_n = 1;
        device->reset = 1;
        for (int i = 0; i < 8; ++i) tick();
        device->reset = 0;
        do tick();
        while (!device->period_ends);
    }

    void emergency(bool pressed) { device->estop_n = !pressed; }

    void period() {
        bool on = true;
        std::array<uint8_t, 4> applied{};
        Trace trace;
        for (int clock = 0; clock < CLOCKS; ++clock) {
            const bool latched = tick();
            on &= !device->oe_n;
            if (latched != (clock % CLOCKS_PER_LEVEL == 0)) fail("a level was not latched when its time was");
            if (device->sync != (clock < CLOCKS_PER_LEVEL)) fail("sync is not at level 0");
            if (latched) trace.level(clock / CLOCKS_PER_LEVEL, registers.outputs);
            if (device->applied) {
                if (applied[0]) fail("two packets went through the gate in one period");
                applied = {1, device->applied_type, device->applied_seq, device->applied_result};
            }
        }
        write(on, applied, trace);
    }

    Host host;

private:
    // One clock. Data that were latched at its beginning are those from before what is shifted in its middle.
    bool tick() {
        device->rxd = host.transmit(clocks);
        device->clk = 1;
        device->eval();
        const bool latched = device->latch && !latch_before;
        latch_before = device->latch;
        if (latched) registers.latch();
        if (device->shift) registers.shift(device->data);
        host.receive(clocks, device->txd);
        device->clk = 0;
        device->eval();
        ++clocks;
        return latched;
    }

    void write(bool on, const std::array<uint8_t, 4> &applied, const Trace &trace) {
        const auto count = uint16_t(host.received.size());
        const auto pulses = trace.pulses();
        std::putchar(on);
        std::fwrite(applied.data(), 1, applied.size(), stdout);
        std::putchar(count & 0xFF);
        std::putchar(count >> 8);
        std::fwrite(host.received.data(), 1, count, stdout);
        std::fwrite(pulses.data(), 1, pulses.size(), stdout);
        host.received.clear();
    }

    std::unique_ptr<Vwatched> device = std::make_unique<Vwatched>();
    Registers registers;
    bool latch_before = false;
    uint64_t clocks = 0;
};

template <typename T> T read() {
    T value;
    if (std::fread(&value, sizeof value, 1, stdin) != 1) fail("a command ended early");
    return value;
}

}  // namespace

int main() {
    Bench bench;
    for (int command; (command = std::getchar()) != EOF;) {
        if (command == 'b') {
            const auto baud = read<double>();
            if (!(baud >= 1000 && baud <= CLOCK_HZ / 2)) fail("this baud cannot be simulated");
            bench.host.baud(baud);
        } else if (command == 'u') {
            for (auto count = read<uint16_t>(); count > 0; --count) bench.host.send(read<uint8_t>());
        } else if (command == 'e') {
            bench.emergency(read<uint8_t>() != 0);
        } else if (command == 'r') {
            for (auto count = read<uint32_t>(); count > 0; --count) bench.period();
            if (std::fflush(stdout) != 0) return 0;
        } else {
            fail("unknown command");
        }
    }
}
