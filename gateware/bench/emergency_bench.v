// emergency: presses from a tenth of a clock to 10 ms, at many phases of the clock, are caught at once and held until
// released; the outputs are off all the while.
`include "check.vh"
`timescale 1ns/1ps
module emergency_bench;
    `include "bench.vh"
    reg  reset = 1, estop_n = 0, let_go = 0;
    wire caught, stopped, pressed;
    emergency emergency (
        .clk(clk), .reset(reset), .estop_n(estop_n), .let_go(let_go), .caught(caught), .stopped(stopped), .pressed(pressed)
    );
    // The outputs of a device that sounds.
    wire on, oe_n;
    outputs outputs (
        .clk(clk), .reset(reset), .last(1'b1), .sounds(1'b1), .caught(caught), .estop_n(estop_n), .on(on), .oe_n(oe_n)
    );
    // And those of one that is slow to catch a press.
    wire on_uncaught, oe_n_uncaught;
    outputs uncaught (
        .clk(clk), .reset(reset), .last(1'b1), .sounds(1'b1), .caught(1'b0), .estop_n(estop_n), .on(on_uncaught), .oe_n(oe_n_uncaught)
    );
    always @(oe_n_uncaught or estop_n) if (!reset) #0.001 `CHECK("off while pressed", oe_n_uncaught, !estop_n || !on_uncaught)
    task release_it;
        begin
            @(negedge clk) let_go = 1;
            @(negedge clk) let_go = 0;
            `CHECK("caught when let go of", caught, !estop_n)
            repeat (2) @(negedge clk);
            `CHECK("stopped two clocks later", stopped, !estop_n)
        end
    endtask
    task press(input real at_ns, input real for_ns);
        begin
            @(posedge clk) #(at_ns) estop_n = 0;
            #0.001 `CHECK("caught and off at once", {caught, on, oe_n}, 3'b111)
            #(for_ns) estop_n = 1;
            #0.001 `CHECK("off after it", oe_n, 1'b1)
            repeat (3) @(negedge clk);
            `CHECK("caught after it", caught, 1'b1)
            `CHECK("stopped after it", stopped, 1'b1)
            `CHECK("pressed after it", pressed, 1'b0)
            repeat (20) @(negedge clk);
            `CHECK("caught for long", {caught, stopped, oe_n}, 3'b111)
            release_it;
            repeat (5) @(negedge clk);
            `CHECK("caught without a press", {caught, stopped, pressed, oe_n}, 4'b0000)
        end
    endtask
    integer phase;
    initial begin
        #1 `CHECK("pressed until known otherwise", pressed || !reset, pressed)
        repeat (4) @(negedge clk);
        `CHECK("pressed at reset", {caught, stopped, pressed}, 3'b111)
        reset = 0;
        repeat (4) @(negedge clk);
        `CHECK("pressed after reset", {caught, stopped, pressed}, 3'b111)
        release_it;
        estop_n = 1;
        repeat (4) @(negedge clk);
        `CHECK("released", {caught, stopped, pressed}, 3'b110)
        release_it;
        for (phase = 1; phase < 100; phase = phase + 9) begin
            press(phase / 10.0, 0.5);
            press(phase / 10.0, 1);
            press(phase / 10.0, 9);
            press(phase / 10.0, 10);
            press(phase / 10.0, 25);
            press(phase / 10.0, 1000);
        end
        press(3.3, 10000000);
        // No release while pressed.
        estop_n = 0;
        release_it;
        repeat (4) @(negedge clk);
        `CHECK("pressed still", {caught, stopped, pressed}, 3'b111)
        `END
    end
endmodule
