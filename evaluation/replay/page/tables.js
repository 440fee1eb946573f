// Tables of the page: packed_table.h has their layout. A table: {rows, t (us since the start, sorted), columns by name}.

async function inflated(text) {
  const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

class Bytes {
  constructor(bytes) {
    this.bytes = bytes;
    this.at = 0;
  }
  // Beyond 2^31 by multiplication: such numbers are rare.
  varint() {
    const bytes = this.bytes;
    let byte = bytes[this.at++];
    if (byte < 128) return byte;
    let value = byte & 127, factor = 128;
    do {
      byte = bytes[this.at++];
      value += (byte & 127) * factor;
      factor *= 128;
    } while (byte >= 128);
    return value;
  }
}

const readers = {
  time(bytes, rows) {
    const values = new Float64Array(rows);
    let last = 0;
    for (let i = 0; i < rows; ++i) values[i] = last += bytes.varint();
    return values;
  },
  number(bytes, rows, column) {
    const values = new Float64Array(rows);
    let last = 0;
    for (let i = 0; i < rows; ++i) {
      const code = bytes.varint();
      if (code === 0) {
        values[i] = NaN;
        continue;
      }
      const zigzag = code - 1;
      last += zigzag % 2 === 0 ? zigzag / 2 : -(zigzag + 1) / 2;
      values[i] = last * column.step;
    }
    return values;
  },
  byte(bytes, rows) {
    const values = bytes.bytes.subarray(bytes.at, bytes.at + rows);
    bytes.at += rows;
    return values;
  },
  word(bytes, rows) {
    const values = new Uint16Array(rows);
    const low = bytes.at, high = bytes.at + rows;
    for (let i = 0; i < rows; ++i) values[i] = bytes.bytes[low + i] | bytes.bytes[high + i] << 8;
    bytes.at += 2 * rows;
    return values;
  },
  bit(bytes, rows) {
    const values = new Uint8Array(rows);
    for (let i = 0; i < rows; ++i) values[i] = bytes.bytes[bytes.at + (i >> 3)] >> (i & 7) & 1;
    bytes.at += (rows + 7) >> 3;
    return values;
  }
};

async function readTable(description, text) {
  const bytes = new Bytes(await inflated(text));
  const table = {name: description.name, rows: description.rows};
  for (const column of description.columns)
    table[column.name] = readers[column.kind](bytes, description.rows, column);
  return table;
}

// The number of rows up to and at time t.
function rowsUntil(table, t) {
  let low = 0, high = table.rows;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (table.t[middle] <= t) low = middle + 1;
    else high = middle;
  }
  return low;
}

// The newest row at t that is at most `age` us old; -1: none.
function rowAt(table, t, age) {
  if (!table) return -1;
  const row = rowsUntil(table, t) - 1;
  return row >= 0 && t - table.t[row] <= age ? row : -1;
}
