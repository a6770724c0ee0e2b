//! The memory in which a device says what it is (ETG.1000.6, 5.4; ETG.2010).

/// A sync manager of it: start, length, control, purpose.
pub type Manager = (u16, u16, u8, u8);

/// Mailboxes: start and length of what comes in and what goes out.
pub const MAILBOX_IN: (u16, u16) = (0x1000, 128);
pub const MAILBOX_OUT: (u16, u16) = (0x1080, 128);

/// The memory of a device with a mailbox.
pub fn eeprom(name: &str, vendor: u32, product: u32, alias: u16, managers: &[Manager], fmmus: &[u8]) -> Vec<u8> {
    let mut words = [0_u16; 0x40];
    words[4] = alias;
    words[8] = vendor as u16;
    words[9] = (vendor >> 16) as u16;
    words[10] = product as u16;
    words[11] = (product >> 16) as u16;
    words[12] = 1;
    (words[0x18], words[0x19]) = MAILBOX_IN;
    (words[0x1a], words[0x1b]) = MAILBOX_OUT;
    words[0x1c] = 4; // CoE
    words[0x3e] = 0x000f;
    words[0x3f] = 1;
    let mut bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let mut category = |kind: u16, mut body: Vec<u8>| {
        body.resize(body.len().next_multiple_of(2), 0);
        bytes.extend(kind.to_le_bytes());
        bytes.extend(((body.len() / 2) as u16).to_le_bytes());
        bytes.extend(body);
    };
    category(10, [&[1, name.len() as u8], name.as_bytes()].concat());
    let mut general = vec![0; 32];
    (general[2], general[3], general[5]) = (1, 1, 0x03);
    category(30, general);
    category(40, fmmus.to_vec());
    let managers = managers.iter().flat_map(|(start, length, control, purpose)| {
        [&start.to_le_bytes()[..], &length.to_le_bytes(), &[*control, 0, 1, *purpose]].concat()
    });
    category(41, managers.collect());
    bytes.extend([0xff; 8]);
    bytes
}
