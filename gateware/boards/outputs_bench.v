// The top module of a board with models of its PLL and output registers: the shift registers' signals to the
// nanosecond, the outputs once the device has been enabled over its line, an emergency stop, a loss of the clock, and the
// PLL's reset. `boards/bench` runs it, with BOARD defined as the folder's name.
`default_nettype none
`timescale 1ns / 1ps

// Locks 2 us after its reset, unless `outputs_bench.lost`.
module pll_model #(parameter real HALF = 12.2) (input wire reset, output reg clk, output reg locked);
    initial {clk, locked} = 2'b00;
    always #(HALF) clk = !clk;
    always @(posedge outputs_bench.lost or posedge reset) locked = 0;
    always @(negedge locked or negedge reset) if (!reset) begin #2000; locked = !outputs_bench.lost; end
    initial begin #2000; locked = 1; end
endmodule

// The first half of a clock brings D0, the second D1.
module register_model (input wire clk, reset, d0, d1, output reg q);
    reg second;
    always @(posedge clk) begin q <= !reset && d0; second <= !reset && d1; end
    always @(negedge clk) q <= second;
endmodule

module EHXPLLL #(
    parameter CLKI_DIV = 1, CLKFB_DIV = 1, FEEDBK_PATH = "", PLLRST_ENA = "", CLKOP_ENABLE = "", CLKOP_DIV = 1, CLKOP_CPHASE = 0,
    parameter CLKOS_ENABLE = "", CLKOS_DIV = 1, CLKOS_CPHASE = 0
) (
    input wire CLKI, CLKFB, RST, STDBY, PLLWAKESYNC, ENCLKOP, ENCLKOS, ENCLKOS2, ENCLKOS3, PHASESEL0, PHASESEL1, PHASEDIR, PHASESTEP, PHASELOADREG,
    output wire CLKOP, output wire CLKOS, output wire LOCK
);
    assign CLKOS = 1'b0;
    pll_model #(20.0 * CLKI_DIV * CLKOP_DIV / CLKOS_DIV) model (.reset(RST), .clk(CLKOP), .locked(LOCK));
endmodule
module ODDRX1F (input wire SCLK, RST, D0, D1, output wire Q);
    register_model model (.clk(SCLK), .reset(RST), .d0(D0), .d1(D1), .q(Q));
endmodule

module rPLL #(
    parameter DEVICE = "", FCLKIN = "", IDIV_SEL = 0, FBDIV_SEL = 0, ODIV_SEL = 0, DYN_SDIV_SEL = 2, CLKOUTD_SRC = "", CLKFB_SEL = ""
) (
    input wire CLKIN, CLKFB, RESET, RESET_P, input wire [5:0] FBDSEL, IDSEL, ODSEL, input wire [3:0] DUTYDA, PSDA, FDLY,
    output wire CLKOUT, CLKOUTP, CLKOUTD, CLKOUTD3, LOCK
);
    pll_model #(500.0 / 27 * (IDIV_SEL + 1) * DYN_SDIV_SEL / (FBDIV_SEL + 1)) model (.reset(RESET), .clk(CLKOUTD), .locked(LOCK));
endmodule
module ODDR (input wire CLK, TX, D0, D1, output wire Q0, output wire Q1);
    register_model model (.clk(CLK), .reset(1'b0), .d0(D0), .d1(D1), .q(Q0));
endmodule

module DCM_CLKGEN #(parameter real CLKIN_PERIOD = 31.25, parameter CLKFX_MULTIPLY = 1, CLKFX_DIVIDE = 1) (
    input wire CLKIN, RST, FREEZEDCM, PROGCLK, PROGDATA, PROGEN, output wire CLKFX, LOCKED, CLKFX180, CLKFXDV, PROGDONE, output wire [2:1] STATUS
);
    pll_model #(CLKIN_PERIOD / 2 * CLKFX_DIVIDE / CLKFX_MULTIPLY) model (.reset(RST), .clk(CLKFX), .locked(LOCKED));
endmodule
module ODDR2 #(parameter DDR_ALIGNMENT = "", INIT = 0, SRTYPE = "") (input wire C0, C1, CE, D0, D1, R, S, output wire Q);
    register_model model (.clk(C0), .reset(R), .d0(D0), .d1(D1), .q(Q));
endmodule
module IBUFG (input wire I, output wire O);
    assign O = I;
endmodule
module BUFG (input wire I, output wire O);
    assign O = I;
endmodule

module outputs_bench;
    parameter PHASE_BITS = 7;

    reg lost = 0, oscillator = 0, rxd = 1, estop_n = 1;
    always #(500000.0 / board.OSCILLATOR_KHZ) oscillator = !oscillator;
    wire [31:0] data;
    wire [3:0]  sclk, rclk;
    wire        oe_n, sync, trigger, txd;
`ifdef ecp5
    wire [2:0] led;
    wire       held_high;
    wire       on = led[0];
    top #(.PHASE_BITS(PHASE_BITS), .OUT_DIVIDE(PHASE_BITS == 8 ? 9 : 18)) board (
        .oscillator(oscillator), .rxd(rxd), .txd(txd), .estop_n(estop_n), .sync_in(1'b0), .trigger_in(1'b0), .address(3'd2), .data(data),
        .sclk(sclk), .rclk(rclk), .oe_n(oe_n), .sync(sync), .trigger(trigger), .led(led), .held_high(held_high)
    );
`elsif tang_nano
    wire [2:0] led_n;
    wire       held_high = 1'b1, on = !led_n[0];
    top #(.PHASE_BITS(PHASE_BITS), .COPIES(1), .LEDS(3)) board (
        .oscillator(oscillator), .rxd(rxd), .txd(txd), .estop_n(estop_n), .sync_in(1'b0), .trigger_in(1'b0), .address(3'd2), .data(data),
        .sclk(sclk[0]), .rclk(rclk[0]), .oe_n(oe_n), .sync(sync), .trigger(trigger), .led_n(led_n)
    );
`else
    wire on;
    wire held_high = 1'b1;
    top #(.PHASE_BITS(PHASE_BITS)) board (
        .oscillator(oscillator), .rxd(rxd), .txd(txd), .estop_n(estop_n), .sync_in(1'b0), .trigger_in(1'b0), .address(2'd2), .data(data),
        .sclk(sclk), .rclk(rclk), .oe_n(oe_n), .sync(sync), .trigger(trigger), .led(on)
    );
`endif
    // ENABLE to address 2, as in doc/protocol.md.
    localparam [103:0] ENABLE = 104'h050302077D010105B9C039CA00;
    integer at, bit_at;
    task enable;
        for (at = 12; at >= 0; at = at - 1) begin
            rxd = 0;
            #500;
            for (bit_at = 0; bit_at < 8; bit_at = bit_at + 1) begin
                rxd = ENABLE[8 * at + bit_at];
                #500;
            end
            rxd = 1;
            #500;
        end
    endtask
    // Outputs are silent: data 0 toggles with every bit instead, the worst case.
    reg bit_now = 0;
    localparam CLOCKS = PHASE_BITS == 5 ? 4 : PHASE_BITS == 6 ? 2 : 1;
    integer clocks = 0;
    wire latch = board.rclk_inside;
    reg  latch_before = 0;
    always @(posedge board.clk) begin
        latch_before <= latch;
        clocks <= latch && !latch_before ? 1 : clocks + 1;
        if (clocks % CLOCKS == 0 || (latch && !latch_before)) bit_now <= !bit_now;
    end

    // The shortest of each, in ns.
    real changed = 0, rose = 0, fell = 0, set_up = 1e9, hold = 1e9, high = 1e9, low = 1e9, to_rclk = 1e9;
    real period = 0, rclk_rose = 0;
    reg  measures = 0;
    always @(bit_now) begin
        if (measures && $realtime - rose < hold) hold = $realtime - rose;
        changed = $realtime;
    end
    always @(posedge sclk[0]) begin
        if (measures && $realtime - changed < set_up) set_up = $realtime - changed;
        if (measures && $realtime - fell < low) low = $realtime - fell;
        rose = $realtime;
    end
    always @(negedge sclk[0]) begin
        if (measures && $realtime - rose < high) high = $realtime - rose;
        fell = $realtime;
    end
    always @(posedge rclk[0]) begin
        if (measures && $realtime - rose < to_rclk) to_rclk = $realtime - rose;
        period = $realtime - rclk_rose;
        rclk_rose = $realtime;
    end

    initial #400000 begin
        $display("%0d phase bits: the outputs do not go on, or the PLL is not reset", PHASE_BITS);
        $finish_and_return(1);
    end

    // Required duration of each, in half clocks.
    real half;
    task expect_halves(input [8*12-1:0] name, input real ns, input integer halves);
        if (ns < halves * half - 0.1 || ns > halves * half + 0.1) begin
            $display("%0d phase bits: %0s is %.2f ns, not %0d half clocks of %.2f ns", PHASE_BITS, name, ns, halves, half);
            $finish_and_return(1);
        end
    endtask

    task expect(input [8*40-1:0] name, input whether);
        if (whether !== 1'b1) begin
            $display("%0d phase bits: %0s", PHASE_BITS, name);
            $finish_and_return(1);
        end
    endtask

    initial begin
        half = 500000.0 * board.native.DIVIDE / board.native.OSCILLATOR_KHZ / board.native.MULTIPLY;
        #10000 expect("silent after power-up", !board.reset && oe_n && !on && held_high);
        // Shortened: all tables are restored.
        board.native.device.restore.next = {14{1'b1}};
        #30000 measures = 1;
        enable;
        measures = 0;
        expect_halves("set-up", set_up, CLOCKS == 1 ? 1 : CLOCKS);
        expect_halves("hold", hold, CLOCKS == 1 ? 1 : CLOCKS);
        expect_halves("SCLK high", high, CLOCKS == 1 ? 1 : 2);
        expect_halves("SCLK low", low, CLOCKS == 1 ? 1 : 2 * CLOCKS - 2);
        expect_halves("SCLK to RCLK", to_rclk, CLOCKS == 1 ? 1 : CLOCKS);
        expect_halves("RCLK period", period, 16 * CLOCKS);
        $display("%0d phase bits: set-up %.1f, hold %.1f, SCLK high %.1f, low %.1f, SCLK to RCLK %.1f ns", PHASE_BITS, set_up, hold, high, low, to_rclk);

        // An emergency stop shorter than a clock, then ENABLE, then a loss of the clock.
        if (PHASE_BITS == 7) begin
            wait (!oe_n) #33 estop_n = 0;
            #1 expect("off by an emergency stop", oe_n);
            #2 estop_n = 1;
            #1 expect("off after an emergency stop", oe_n);
            enable;
            expect("off until ENABLE takes effect", oe_n);
        end
        wait (!oe_n) #33 expect("on", on);
        lost = 1;
        #1 expect("off by a lost clock", oe_n);
        #100 expect("reset by a lost clock", board.reset && oe_n);
        // Shortened.
        board.native.power_up.waited = 21'h1FFFE0;
        @(posedge board.pll_reset) lost = 0;
        #5000 expect("the clock comes back after the PLL's reset", !board.reset && !board.pll_reset && oe_n);
        $finish_and_return(0);
    end
endmodule

`default_nettype wire
