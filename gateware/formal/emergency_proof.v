// emergency, safety and outputs, with ENABLE and RESET as in the gate's proof: after a low `estop_n` of a single clock,
// the outputs are off from that clock on until released, and nothing is enabled from three clocks later (two of the
// synchroniser) until the next ENABLE. They are also off after a reset, and on only from the beginning of a period.
`default_nettype none
module emergency_proof (
    input wire clk,
    input wire estop_n,
    input wire last,            // arbitrary
    input wire sounds,
    input wire any_let_go,
    input wire for_enable,      // or RESET
    input wire boundary
);
    reg reset = 1'b1;
    always @(posedge clk) reset <= 1'b0;

    // The gate releases the stop, and enables or restarts four clocks later.
    reg [3:0] since = 4'd0;
    reg       enables;
    wire      let_go = any_let_go && since == 4'd0 && !reset;
    wire      acts = since == 4'd4;
    always @(posedge clk) begin
        since <= let_go ? 4'd1 : since == 4'd0 || acts ? 4'd0 : since + 4'd1;
        if (let_go) enables <= for_enable;
        if (reset) since <= 4'd0;
    end

    wire caught, stopped, pressed, enabled, tripped;
    emergency emergency (
        .clk(clk), .reset(reset), .estop_n(estop_n), .let_go(let_go), .caught(caught), .stopped(stopped), .pressed(pressed)
    );
    safety safety (
        .clk(clk), .reset(reset), .restart(acts && !enables), .count(1'b0), .boundary(boundary), .emergency(stopped || pressed),
        .good_packet(1'b0), .enable(acts && enables), .enable_watchdog(16'd0), .mute(1'b0), .enabled(enabled), .tripped(tripped)
    );
    wire on, oe_n;
    outputs outputs (
        .clk(clk), .reset(reset), .last(last), .sounds(sounds), .caught(caught), .estop_n(estop_n), .on(on), .oe_n(oe_n)
    );

    // Pressed at any clock since the last release, and clocks since then.
    reg       was_pressed = 1'b0;
    reg [2:0] clocks;
    always @(posedge clk) begin
        if (!estop_n) was_pressed <= 1'b1;
        else if (let_go) was_pressed <= 1'b0;
        clocks <= !was_pressed ? 3'd1 : clocks == 3'd7 ? 3'd7 : clocks + 3'd1;
        if (reset) was_pressed <= 1'b0;
    end
    reg was_reset = 1'b1, was_off, begins;
    always @(posedge clk) {was_reset, was_off, begins} <= {reset, !on, last && sounds};
    always @(posedge clk) if (!reset) begin
        if (was_reset) assert (oe_n);
        if (was_off && on) assert (begins);
        if (!estop_n || was_pressed) assert (oe_n);
        if (was_pressed && clocks >= 3'd4) assert (!enabled && tripped);
        cover (enabled && !oe_n);
        cover (was_pressed && estop_n && !pressed && clocks == 3'd7);
        cover (acts && enables && was_pressed && estop_n);
    end
endmodule
