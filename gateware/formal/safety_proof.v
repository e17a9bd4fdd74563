// safety: only ENABLE switches on; the watchdog trips in its period, the emergency stop at once, and a tripped device
// stays off until ENABLE or RESET.
`default_nettype none
module safety_proof (
    input wire        clk,
    input wire        period,           // one begins
    input wire        emergency,
    input wire        good_packet,
    input wire        enable,
    input wire [15:0] enable_watchdog,
    input wire        mute,
    input wire        restart
);
    reg reset = 1'b1;
    always @(posedge clk) reset <= 1'b0;

    // As in the device: a period is counted in one clock and evaluated in the next, and packets come at other times.
    reg boundary = 1'b0;
    always @(posedge clk) boundary <= period && !boundary && !reset;
    wire count = period && !boundary;
    wire packet = good_packet && !count && !boundary;

    wire enabled, tripped;
    safety #(.UNIT_BITS(1)) safety (
        .clk(clk), .reset(reset), .restart(packet && restart && !enable && !mute), .count(count), .boundary(boundary), .emergency(emergency), .good_packet(packet),
        .enable(packet && enable), .enable_watchdog(enable_watchdog), .mute(packet && mute && !enable),
        .enabled(enabled), .tripped(tripped)
    );

    reg [15:0] watchdog;
    reg [15:0] quiet;
    reg        was_enabled, was_tripped, was_reset = 1'b1, told_on, told_off, restarted, boundary_before, emergency_before, late_before;
    always @(posedge clk) begin
        if (packet && enable) watchdog <= enable_watchdog;
        quiet <= packet ? 16'd0 : quiet + count;
        if (reset) {watchdog, quiet} <= 0;
        {was_enabled, was_tripped, was_reset} <= {enabled, tripped, reset};
        restarted <= packet && restart && !enable && !mute;
        if (packet && restart && !enable && !mute) watchdog <= 16'd0;
        {told_on, told_off} <= {packet && enable, packet && mute && !enable};
        {boundary_before, emergency_before} <= {boundary, emergency};
        late_before <= watchdog != 0 && quiet >= {watchdog[14:0], 1'b0} && !watchdog[15];
    end

    always @(posedge clk) if (!reset && !was_reset) begin
        if (tripped) assert (!enabled);
        if (enabled && !was_enabled) assert (told_on && !emergency_before);
        if (was_tripped && !told_on && !restarted) assert (tripped && !enabled);
        if (boundary_before && late_before) assert (!enabled);
        if (emergency_before) assert (tripped && !enabled);
        if (tripped && !was_tripped) assert (emergency_before || (boundary_before && late_before));
        if (was_enabled && !enabled) assert (told_off || restarted || tripped);
        cover (restarted && was_tripped && !tripped);
        cover (tripped && !emergency_before && late_before);
        cover (enabled && was_tripped);
    end
    always @(posedge clk) if (reset) assume (!period);
endmodule
