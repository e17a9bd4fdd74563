// safety and sweep, reduced (8 channels, 32 clocks per period, a mute of 2 periods): after a trip, outputs are silent
// from the second sweep on, for any frames and silencer steps, until ENABLE.
`default_nettype none
module mute_proof (
    input wire        clk,
    input wire [7:0]  phase,
    input wire [7:0]  amplitude,
    input wire [7:0]  envelope,
    input wire        emergency,
    input wire        enable,
    input wire        set_steps,
    input wire [15:0] any_step,
    input wire [2:0]  any_channel,
    input wire [7:0]  any_gain
);
    reg reset = 1'b1;
    always @(posedge clk) reset <= 1'b0;

    wire count, boundary, start, open, last;
    ticks #(.PERIOD_BITS(5), .PHASE_BITS(2), .BOUNDARY(4), .GATE(24)) ticks (
        .clk(clk), .reset(reset), .hold(1'b0), .skip(1'b0), .last(last), .count(count), .boundary(boundary), .sweep(start), .gate(open)
    );
    wire enabled, tripped, sounds;
    wire [2:0] channel;
    safety safety (
        .clk(clk), .reset(reset), .restart(1'b0), .count(count), .boundary(boundary), .emergency(emergency), .good_packet(open),
        .enable(enable && open), .enable_watchdog(16'd0), .mute(1'b0), .enabled(enabled), .tripped(tripped)
    );
    sweep #(.CHANNEL_BITS(3), .PHASE_BITS(5), .MUTE_STEP(16'h8000)) sweep (
        .clk(clk), .reset(reset), .restart(1'b0), .start(start), .enabled(enabled), .channel(channel),
        .phase(phase), .amplitude(amplitude), .envelope(envelope),
        .set_steps(set_steps && open), .set_phase_step(any_step), .set_amplitude_step(any_step),
        .write_offset(1'b0), .write_gain(open), .write_width(1'b0), .write_address({5'd0, any_channel}),
        .offset_written(8'd0), .gain_written(any_gain), .width_written(8'd0), .digesting(1'b0), .digest_address(8'd0),
        .sounds(sounds)
    );

    // Sweeps since the trip.
    reg [3:0] muted = 4'd0;
    always @(posedge clk) begin
        if (!tripped) muted <= 4'd0;
        else if (start && muted != 4'd15) muted <= muted + 4'd1;
    end
    always @(posedge clk) if (!reset && open) begin
        if (muted >= 4'd2) assert (!sounds);
        cover (muted == 4'd1 && sounds);
        cover (enabled && sounds);
    end
endmodule
