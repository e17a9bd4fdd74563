// receiver and gate, with any bytes at any time (payloads are arbitrary, too, instead of a memory): writes, signals
// and commits happen only for packets with the right CRC for this device or for all, and only in the gate's time; and
// broadcasts are not answered. The CRC is recomputed here bit by bit.
`include "packets.vh"
`default_nettype none
module door_proof (
    input wire       clk,
    input wire       valid,
    input wire [7:0] data,
    input wire       framing,
    input wire       open,
    input wire       pressed,
    input wire       sounding,
    input wire       restored,
    input wire       digested,
    input wire [2:0] any_address,
    input wire       slot_busy,
    input wire       answered,
    input wire [7:0] any_data
);
    reg reset = 1'b1;
    always @(posedge clk) reset <= 1'b0;

    reg [2:0] address;
    always @(posedge clk) if (reset) address <= any_address;
    wire        ready, done, good, broadcast, at_work, passed, answer;
    wire [7:0]  packet_type, packet_seq, result;
    wire [31:0] arguments;
    wire [9:0]  length;
    receiver receiver (
        .clk(clk), .reset(reset), .valid(valid && !reset), .data(data), .framing(framing && !reset), .address(address),
        .ready(ready), .broadcast(broadcast), .packet_type(packet_type), .packet_seq(packet_seq), .arguments(arguments), .length(length),
        .done(done), .good(good)
    );
    wire       enable, mute, baud, stop, rate, silencer, play, restart, let_go;
    wire [5:0] play_first, play_last;
    wire [15:0] play_divider;
    wire       write_phase, write_amplitude, write_envelope, write_width, write_offset, write_gain;
    gate gate (
        .clk(clk), .reset(reset), .open(open), .ready(ready), .broadcast(broadcast), .packet_type(packet_type), .arguments(arguments), .length(length),
        .read_data(any_data), .done(done), .pressed(pressed), .sounding(sounding), .restored(restored), .digested(digested), .slot_busy(slot_busy),
        .at_work(at_work), .passed(passed), .result(result), .answer(answer), .answered(answered),
        .let_go(let_go), .restart(restart), .enable(enable), .mute(mute), .baud(baud), .stop(stop), .rate(rate), .silencer(silencer), .play(play),
        .play_first(play_first), .play_last(play_last), .play_divider(play_divider),
        .write_phase(write_phase), .write_amplitude(write_amplitude), .write_envelope(write_envelope),
        .write_width(write_width), .write_offset(write_offset), .write_gain(write_gain)
    );

    // COBS and CRC again, by their definitions.
    function [31:0] longer(input [31:0] start, input [7:0] value);
        integer i;
        begin
            longer = start ^ {24'd0, value};
            for (i = 0; i < 8; i = i + 1) longer = longer[0] ? {1'b0, longer[31:1]} ^ 32'hEDB88320 : {1'b0, longer[31:1]};
        end
    endfunction
    reg [7:0]  left;
    reg        begun, no_zero, bad;
    reg [9:0]  count;
    reg [31:0] crc;
    reg [7:0]  kind, to;
    wire       whole = valid && data == 8'd0 && begun && !bad && left == 8'd0 && crc == 32'hDEBB20E3 && count >= 10'd11;
    wire       right = whole && !kind[7] && (to == {5'd0, address} || to == 8'hFF);
    wire       zero = left == 8'd0 && begun && !no_zero;
    always @(posedge clk) begin
        if (valid && data != 8'd0) begin
            begun <= 1'b1;
            left <= left == 8'd0 ? data - 8'd1 : left - 8'd1;
            if (left == 8'd0) no_zero <= data == 8'hFF;
            if (left != 8'd0 || zero) begin
                crc <= longer(crc, left == 8'd0 ? 8'd0 : data);
                count <= count + 10'd1;
                if (count == 10'd0) kind <= left == 8'd0 ? 8'd0 : data;
                if (count == 10'd1) to <= left == 8'd0 ? 8'd0 : data;
            end
        end
        if (framing) {begun, bad} <= 2'b11;
        if (reset || (valid && data == 8'd0)) {left, begun, no_zero, bad, count, crc} <= {8'd0, 1'b0, 1'b0, 1'b0, 10'd0, 32'hFFFFFFFF};
    end

    // Correct packets not yet passed; whether the gate has been opened for one.
    reg [7:0] credit;
    reg       opened;
    wire      tells = let_go || restart || enable || mute || baud || stop || rate || silencer || play;
    wire      writes = write_phase || write_amplitude || write_envelope || write_width || write_offset || write_gain;
    always @(posedge clk) begin
        credit <= credit + (right && !reset) - done;
        if (open) opened <= 1'b1;
        if (done) opened <= 1'b0;
        if (reset) {credit, opened} <= 0;
    end

    always @(posedge clk) if (!reset) begin
        if (tells || writes) assert (credit != 8'd0 && opened && at_work && result == `RESULT_OK);
        if (passed) assert (credit != 8'd0 && opened);
        if (play) assert (play_first <= play_last && play_divider != 16'd0);
        if (answer) assert (!broadcast);
        cover (mute);
        cover (enable && arguments[23:16] == `CONFIRM);
        cover (mute && broadcast);
        cover (whole && !right);
        cover (passed && length == 10'd1 && packet_type == `TYPE_INFO);
    end
endmodule
